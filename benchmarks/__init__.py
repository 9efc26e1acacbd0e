"""Speed of contiga beside other codes, in one run and on moving data."""
