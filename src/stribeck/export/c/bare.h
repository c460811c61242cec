/* Windows without the start-up code of MinGW: nothing here needs it, and it is larger than the model.
 *
 * Memory, mathematics and text come from ucrtbase.dll, which is part of Windows since version 10 and sets itself up.
 * Other builds leave this out: the build script of the exporter defines FM_BARE and links with -nostdlib.
 */
#if defined FM_BARE && defined _WIN32
#include <stdio.h> /* declares __stdio_common_vsprintf, of which vsnprintf is made */

int _fltused = 0;

static int fm_text(char *out, size_t size, const char *format, va_list arguments) {
    return __stdio_common_vsprintf(2, out, size, format, NULL, arguments); /* 2: always ends the text */
}
#define vsnprintf fm_text

int __stdcall DllMainCRTStartup(void *library, unsigned long reason, void *reserved) {
    (void)library, (void)reason, (void)reserved;
    return 1;
}
#endif
