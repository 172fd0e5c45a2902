"""The contrast of two colours, which makes a text readable or not."""


def contrast(one: str, other: str) -> float:
    """Return the contrast [-] of two colours, 1 to 21, as WCAG 2 defines it."""
    light, dark = sorted((luminance(one), luminance(other)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def luminance(colour: str) -> float:
    """Return the relative luminance [-] of #rgb or #rrggbb, as WCAG 2 defines it."""
    size = len(colour) // 3
    digits = (colour[i : i + size] for i in range(1, 1 + 3 * size, size))
    parts = (int((2 * digit)[:2], 16) / 255.0 for digit in digits)
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
