"""Arguments are checked where they are given; records that hold arrays compare by value."""
