/* How a library's structures and names are laid out: mirrored.py compares them with those of Python. */
#ifndef SB_MIRRORED_H
#define SB_MIRRORED_H

#include "control.h"

#define SB_QUOTE(text) #text ";"

/* Exported. The declarations of a structure's fields, from the list of them, and its size. */
#define SB_TELL_STRUCTURE(structure, list)                                    \
    SB_EXPORT const char *structure##_fields(void) { return list(SB_QUOTE); } \
    SB_EXPORT long long structure##_size(void) { return (long long)sizeof(structure); }

/* Exported. The names of an enumeration, from the list of them. */
#define SB_TELL_NAMES(name, list) \
    SB_EXPORT const char *name##_names(void) { return list(SB_QUOTE); }

SB_TELL_STRUCTURE(sb_axis, SB_AXIS)
SB_TELL_STRUCTURE(sb_memory, SB_MEMORY)
SB_TELL_NAMES(sb_kinds, SB_KINDS)
SB_TELL_NAMES(sb_at_zero, SB_AT_ZERO)
SB_TELL_NAMES(sb_courses, SB_COURSES)

#endif
