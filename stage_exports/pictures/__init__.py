"""Pictures and movies are drawn off-screen in this room."""
