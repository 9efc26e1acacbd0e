"""The compiled inner loops of contact.

- `place_nb`: what is known of points after they have moved, and which have to be looked at
"""
