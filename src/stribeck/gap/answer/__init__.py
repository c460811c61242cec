"""What a finished search says: verdict, causes, where and how far, as a diagnosis and its files."""
