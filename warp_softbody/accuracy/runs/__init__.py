"""Running a case in this and in other programs, kept in a journal, on several workers."""
