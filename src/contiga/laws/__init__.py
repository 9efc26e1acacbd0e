"""Laws: from penetration and area to force."""
