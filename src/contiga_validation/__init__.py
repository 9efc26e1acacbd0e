"""Evidence: experiments that show what contiga does, beside the numbers of others."""
