"""From penetration and area to force."""
