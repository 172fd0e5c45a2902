"""A page printed as PDF, by a browser found on this machine.

Guides and debriefs are HTML; ``--pdf`` prints them as any reader would see them.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final

from trainer.config.files import ConfigError
from trainer.io.outputs import replacing

# fmt: off
BROWSER_NAMES: Final = (
    "chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome",
    "microsoft-edge", "microsoft-edge-stable", "msedge", "chromium-headless-shell",
)
# fmt: on
MAC_PATHS: Final = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
)
WINDOWS_PATHS: Final = (
    "Google/Chrome/Application/chrome.exe",
    "Chromium/Application/chrome.exe",
    "Microsoft/Edge/Application/msedge.exe",
)
WINDOWS_FOLDERS: Final = ("PROGRAMFILES", "PROGRAMFILES(X86)", "LOCALAPPDATA")  # of Windows
PRINT_TIMEOUT_S: Final = 120.0  # [s]


def find_browser() -> str | None:
    """Return a Chromium, Chrome or Edge, None if there is none."""
    for name in BROWSER_NAMES:
        if path := shutil.which(name):
            return path
    paths = [Path(path) for path in MAC_PATHS]
    paths += [
        Path(os.environ.get(each, "")) / path for each in WINDOWS_FOLDERS for path in WINDOWS_PATHS
    ]
    return next((str(path) for path in paths if path.is_absolute() and path.is_file()), None)


def print_pdf(html: Path, pdf: Path) -> None:
    """Print a page to ``pdf``, which is replaced. ConfigError if no browser is there to do it."""
    browser = find_browser()
    if browser is None:
        raise ConfigError(
            f"--pdf {pdf}: no Chromium, Chrome or Edge is on this machine: install one, or open "
            "the HTML page in a browser and print it from there"
        )
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        printed = Path(folder) / "page.pdf"
        said = _print(browser, html, printed)
        if not printed.is_file():
            raise ConfigError(
                f"--pdf {pdf}: {browser} printed nothing: {said or 'it does not say why'}; open "
                "the HTML page in a browser and print it from there"
            )
        try:
            with replacing(pdf) as made:
                shutil.copyfile(printed, made)
        except OSError as error:
            raise ConfigError(f"--pdf {pdf}: cannot be written: {error.strerror}") from None


def _print(browser: str, html: Path, pdf: Path) -> str:
    """Print by the browser. Return the last line that it wrote to its error output."""
    confined = hasattr(os, "geteuid") and os.geteuid() != 0  # a browser's sandbox refuses root
    words = [
        browser,
        "--headless",
        "--disable-gpu",
        "--no-pdf-header-footer",
        "--no-first-run",
        *(() if confined or sys.platform == "win32" else ("--no-sandbox",)),
        f"--user-data-dir={pdf.parent / 'profile'}",
        f"--print-to-pdf={pdf}",
        html.resolve().as_uri(),
    ]
    try:
        done = subprocess.run(  # noqa: S603 (a browser found by its name)
            words,
            capture_output=True,
            timeout=PRINT_TIMEOUT_S,
            check=False,
            text=True,
            errors="replace",
        )
    except subprocess.TimeoutExpired:
        return f"not done within {PRINT_TIMEOUT_S:g} s"
    except OSError as error:
        return str(error.strerror)
    lines = done.stderr.strip().splitlines()
    return lines[-1] if lines else ""
