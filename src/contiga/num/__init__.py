"""Small numerical helpers shared by every room."""
