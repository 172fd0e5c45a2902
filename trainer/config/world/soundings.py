"""Soundings on a grid, read from ESRI ASCII or GeoTIFF, and carried as a text.

``bottom`` reads an exercise's chart by it. The table [bottom] of an exercise names the file. A
recording holds the text, so that a replay needs neither the file nor its reader.
"""

import base64
import json
import math
import re
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from trainer.config.extras import advise_install
from trainer.config.files import ConfigError, nearest, quote, read_kept, read_text
from trainer.io.outputs import note_input

Numbers = NDArray[np.float64]

MAX_CELLS: Final = 4_000_000  # at most
MAX_FILE_BYTES: Final = 100_000_000  # of a file, at most
# fmt: off
GRID_KEYWORDS: Final = (
    "ncols", "nrows", "xllcorner", "xllcenter", "yllcorner", "yllcenter", "cellsize",
    "dx", "dy", "nodata_value",
)
# fmt: on
MAX_DEPTH_M: Final = 12_000.0  # [m] of any sea: what is beyond is no depth
DEFAULT_NODATA_VALUE: Final = -9999.0  # at a sample without a value, where the file names no other
HEADER_LINE: Final = re.compile(r"[ \t]*([A-Za-z_]\w*)[ \t]+(\S+)[ \t]*(?:\r\n|\r|\n|$)")
SOUNDINGS_PREFIX: Final = "soundings/1 "  # what the text of a grid begins with
SCALE_TAG, TIE_POINT_TAG, GEO_KEYS_TAG, NODATA_TAG = 33550, 33922, 34735, 42113  # tags
VALUES_TAG: Final = 42112  # GDAL's: what a sample is multiplied by, and what is added
VALUES_ITEM: Final = re.compile(r'<Item[^>]*\brole="(scale|offset)"[^>]*>\s*([^<\s]+)\s*</Item>')
# Keys of the tag GEO_KEYS_TAG.
RASTER_TYPE_KEY, GEOGRAPHIC_KEY, PROJECTED_KEY, LINEAR_UNIT_KEY = 1025, 2048, 3072, 3076
PIXEL_IS_POINT, WGS84_CODE, USER_DEFINED_CODE, METRE_CODE = 2, 4326, 32767, 9001  # of GeoTIFF
# Compressions that tifffile does not read without another library.
UNREAD_COMPRESSIONS: Final = {5: "LZW", 6: "old JPEG", 7: "JPEG", 34887: "LERC"}
CONVERT_COMMAND: Final = "gdal_translate -co COMPRESS=DEFLATE IN.tif OUT.tif"
WARP_HINT: Final = "gdalwarp -t_srs EPSG:4326 IN.tif OUT.tif"
LATTICE_KNOTS: Final = 33  # of the lattice on which the chart is computed, each way
Position = Callable[[float, float], tuple[float, float]]
M_PER_DEGREE: Final = 111_132.0  # [m] of a degree of latitude, about


@dataclass(frozen=True, eq=False)
class Grid:
    """Values at the points of a grid, the southernmost row first, NaN for none."""

    values: Numbers  # (rows, columns), as the file has them
    west: float  # [m] or [deg] of the first column
    south: float  # [m] or [deg] of the first row
    cell: tuple[float, float]  # [m] or [deg] from row to row, and from column to column
    degrees: bool


def read_grid(path: Path) -> Grid:
    """Return the grid in a file; ConfigError if it is none."""
    return _from_text(read_kept(path, _as_text), path)


def read_as_kept(path: Path, kept: str) -> str:
    """Return the text of a file now, in the form that a recording kept. ConfigError."""
    return read_kept(path, _as_text) if kept.startswith(SOUNDINGS_PREFIX) else read_text(path)


def _as_text(path: Path) -> str:
    """Return the grid in a file on disk as a text."""
    try:
        note_input(path)
        with path.open("rb") as file:
            data = file.read(MAX_FILE_BYTES + 1)
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from None
    if len(data) > MAX_FILE_BYTES:
        raise ConfigError(f"{path}: is larger than the limit of {MAX_FILE_BYTES} bytes; not read")
    tiff = data[:4] in (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
    grid = read_geotiff(path) if tiff else read_ascii(data, path)
    rows, columns = grid.values.shape
    head = json.dumps([rows, columns, grid.west, grid.south, *grid.cell, grid.degrees])
    packed = base64.b85encode(zlib.compress(grid.values.astype("<f8").tobytes(), 6))
    return f"{SOUNDINGS_PREFIX}{head}\n{packed.decode()}\n"


def _from_text(text: str, path: Path) -> Grid:
    """Return the grid of a text; ConfigError if that is damaged."""
    try:
        head, packed, _ = text.removeprefix(SOUNDINGS_PREFIX).split("\n")
        rows, columns, west, south, down, across, degrees = json.loads(head)
        values = np.frombuffer(zlib.decompress(base64.b85decode(packed)), "<f8")
        values = values.reshape(rows, columns).astype(np.float64)
    except (ValueError, zlib.error):
        raise ConfigError(f"{path}: is no grid as recordings keep one") from None
    return Grid(values, west, south, (down, across), degrees)


# ESRI ASCII


def read_ascii(data: bytes, path: Path) -> Grid:
    """Return the grid of an ESRI ASCII grid's bytes; ConfigError with what is wrong."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        why = ", it is packed: gunzip it" if data.startswith(b"\x1f\x8b") else ""
        raise ConfigError(f"{path}: is not UTF-8 text (byte {error.start} is wrong{why})") from None
    header, at = _keywords(text, path)
    rows, columns = (_count(header, name, path) for name in ("nrows", "ncols"))
    sizes = ("dy", "dx") if "dx" in header and "cellsize" not in header else ("cellsize",) * 2
    down, across = (_number(header, name, path) for name in sizes)
    for name, size in zip(sizes, (down, across), strict=True):
        if size <= 0.0:
            raise _wrong(path, name, header[name], "must be above 0")
    _refuse_large(rows, columns, path)
    values = _samples(text[at:], rows * columns, path).reshape(rows, columns)
    depths = _without_absent(values, header.get("nodata_value", f"{DEFAULT_NODATA_VALUE}"), path)
    west, south = _low(header, "x", across, path), _low(header, "y", down, path)
    return Grid(depths[::-1], west, south, (down, across), degrees=False)


def _without_absent(
    values: Numbers, said: str, path: Path, size: float = 1.0, added: float = 0.0
) -> Numbers:
    """Return a raster's depths, NaN where its values are ``said`` or too deep; ConfigError.

    A depth is a value times ``size`` with ``added`` [m].

    Programs print that value with other digits than the samples, so it is compared roughly.
    """
    plain = said.strip("\0 ").lower()
    absent = math.nan if plain == "nan" else _number({"nodata_value": plain}, "nodata_value", path)
    depths = np.where(np.isclose(values, absent), np.nan, size * values + added)
    beyond = np.abs(depths) > MAX_DEPTH_M
    if beyond.any() and not np.isclose(depths[beyond], depths[beyond][0]).all():
        fault = f"sample {int(np.argmax(beyond)) + 1} = {depths[beyond][0]:g}: no sea is deeper"
        raise ConfigError(f"{path}: {fault} than {MAX_DEPTH_M:g} m: is the grid in metres?")
    return np.where(beyond, np.nan, depths)


def _keywords(text: str, path: Path) -> tuple[Mapping[str, str], int]:
    """Return what the keywords say, and where the samples begin."""
    header: dict[str, str] = {}
    at = 0
    while (match := HEADER_LINE.match(text, at)) and match[1].lower() not in ("nan", "inf"):
        name = match[1].lower()
        if name not in GRID_KEYWORDS:
            raise ConfigError(f"{path}: {match[1]}: no such keyword{nearest(name, GRID_KEYWORDS)}")
        if name in header:
            raise ConfigError(f"{path}: {match[1]} is given twice")
        header[name], at = match[2], match.end()
    return header, at


def _number(header: Mapping[str, str], name: str, path: Path) -> float:
    """Return the number of a keyword; ConfigError if it is lacking or none."""
    if name not in header:
        raise ConfigError(f"{path}: lacks {name.upper()}: is it an ESRI ASCII grid?")
    try:
        number = float(header[name])
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise _wrong(path, name, header[name], "must be a finite number")
    return number


def _count(header: Mapping[str, str], name: str, path: Path) -> int:
    """Return a number of rows or columns; ConfigError if it is none."""
    number = _number(header, name, path)
    if number != int(number) or number < 1:
        raise _wrong(path, name, header[name], "must be a whole number above 0")
    return int(number)


def _low(header: Mapping[str, str], axis: str, cell: float, path: Path) -> float:
    """Return where the first sample is on an axis, by the corner or the centre of its cell."""
    ends = [end for end in ("corner", "center") if f"{axis}ll{end}" in header]
    other = [
        end for end in ("corner", "center") if f"{'y' if axis == 'x' else 'x'}ll{end}" in header
    ]
    if len(ends) != 1 or ends != other:
        raise ConfigError(
            f"{path}: give XLLCORNER and YLLCORNER, or XLLCENTER and YLLCENTER, both of one kind"
        )
    low = _number(header, f"{axis}ll{ends[0]}", path)
    return low + 0.5 * cell if ends == ["corner"] else low


def _samples(text: str, count: int, path: Path) -> Numbers:
    """Return the samples of a grid; ConfigError if one is wrong, or their number is."""
    words = text.split()
    if len(words) != count:
        raise ConfigError(f"{path}: has {len(words)} samples; NROWS times NCOLS is {count}")
    try:
        values = np.array(words, np.float64)
    except ValueError:
        wrong = next(i for i, word in enumerate(words) if not _is_number(word))
        raise ConfigError(
            f"{path}: sample {wrong + 1} = {quote(words[wrong])}: is no number"
        ) from None
    if np.isinf(values).any():
        wrong = int(np.argmax(np.isinf(values)))
        raise ConfigError(f"{path}: sample {wrong + 1} = {words[wrong]}: must be finite, or nan")
    return values


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _refuse_large(rows: int, columns: int, path: Path) -> None:
    if rows * columns > MAX_CELLS:
        raise ConfigError(
            f"{path}: {rows} x {columns} samples: {MAX_CELLS} at most; take every n-th"
        )
    if min(rows, columns) < 2:
        raise ConfigError(f"{path}: {rows} x {columns} samples: at least 2 x 2")


def _wrong(path: Path, name: str, value: object, fault: str) -> ConfigError:
    return ConfigError(f"{path}: {name.upper()} = {value}: {fault}")


# GeoTIFF


def read_geotiff(path: Path) -> Grid:
    """Return the grid of a GeoTIFF; ConfigError if it is of a form not read."""
    try:
        import tifffile  # noqa: PLC0415  an extra
    except ImportError:
        raise ConfigError(advise_install("tifffile", f"{path}: a GeoTIFF")) from None
    try:
        with tifffile.TiffFile(path) as file:
            page = file.pages.first
            tags = {
                number: page.tags[number].value
                for number in (SCALE_TAG, TIE_POINT_TAG, GEO_KEYS_TAG, NODATA_TAG, VALUES_TAG)
                if number in page.tags
            }
            _refuse_coding(int(page.compression), path)
            _refuse_large(int(page.shape[0]), int(page.shape[1]), path)
            values = np.asarray(page.asarray(), np.float64)
    except ConfigError:
        raise
    except ModuleNotFoundError:  # Python's own, which tifffile has for zstd
        message = f"is compressed by ZSTD, which needs Python 3.14: {CONVERT_COMMAND}"
        raise ConfigError(f"{path}: {message}") from None
    except Exception as error:  # noqa: BLE001  whatever a damaged file makes of its reader
        raise ConfigError(f"{path}: is no GeoTIFF that can be read: {error}") from None
    return _locate_raster(values, tags, path)


def _refuse_coding(code: int, path: Path) -> None:
    if code in UNREAD_COMPRESSIONS:
        raise ConfigError(
            f"{path}: is compressed by {UNREAD_COMPRESSIONS[code]}, which is not read: "
            f"{CONVERT_COMMAND}"
        )


def _locate_raster(values: Numbers, tags: Mapping[int, Any], path: Path) -> Grid:
    """Return a raster as a grid, by its tags."""
    if values.ndim != 2:
        raise ConfigError(f"{path}: has {values.ndim} dimensions: one band of depths is read")
    if SCALE_TAG not in tags or TIE_POINT_TAG not in tags:
        raise ConfigError(f"{path}: does not say where it lies (tags 33550 and 33922)")
    keys = dict(_keys(tags.get(GEO_KEYS_TAG, ())))
    _refuse_elsewhere(keys, path)
    across, down = (float(each) for each in tags[SCALE_TAG][:2])
    column, row, _, x, y = (float(each) for each in tags[TIE_POINT_TAG][:5])
    half = 0.0 if keys.get(RASTER_TYPE_KEY) == PIXEL_IS_POINT else 0.5
    west = x + (half - column) * across
    south = y - (values.shape[0] - 1 + half - row) * down
    said = dict(VALUES_ITEM.findall(str(tags.get(VALUES_TAG, ""))))
    header = {"scale": "1", "offset": "0", **said}
    size, added = (_number(header, name, path) for name in ("scale", "offset"))
    if size == 0.0:
        raise _wrong(path, "scale", header["scale"], "must not be 0")
    known = np.where(np.isfinite(values), values, np.nan)
    depths = _without_absent(known, str(tags.get(NODATA_TAG, "nan")), path, size, added)[::-1]
    return Grid(
        depths, west, south, (down, across), GEOGRAPHIC_KEY in keys and PROJECTED_KEY not in keys
    )


def _keys(directory: Any) -> Iterator[tuple[int, int]]:
    """Yield the keys of a GeoTIFF that are numbers, with their values."""
    numbers = list(directory)
    for i in range(4, len(numbers) - 3, 4):
        key, tag, count, value = numbers[i : i + 4]
        if tag == 0 and count == 1:
            yield int(key), int(value)


def _refuse_elsewhere(keys: Mapping[int, int], path: Path) -> None:
    """Raise ConfigError unless a grid is in plain metres or in degrees of WGS 84."""
    projected, geographic = keys.get(PROJECTED_KEY), keys.get(GEOGRAPHIC_KEY, WGS84_CODE)
    if projected not in (None, USER_DEFINED_CODE):
        raise ConfigError(f"{path}: is in EPSG:{projected}; plain metres or EPSG:4326: {WARP_HINT}")
    if keys.get(LINEAR_UNIT_KEY, METRE_CODE) != METRE_CODE:
        raise ConfigError(
            f"{path}: its unit is EPSG:{keys[LINEAR_UNIT_KEY]}, not the metre: {WARP_HINT}"
        )
    if projected is None and geographic != WGS84_CODE:
        raise ConfigError(
            f"{path}: is in EPSG:{geographic}; plain metres or EPSG:4326: {WARP_HINT}"
        )


# From degrees to the plane


def on_the_plane(grid: Grid, position: Position) -> Grid:
    """Return a grid of degrees sampled on the exercise's plane.

    Its cells are as long as those of degrees are from row to row. ``position`` is the chart's: from
    north and east [m] to latitude and longitude [deg]. It is computed only on a lattice, and is
    linear between the knots: off by 0.1 m where they are 3 km apart.
    """
    rows, columns = grid.values.shape
    (south, north), (west, east) = _extent(grid, position)
    cell = max(grid.cell[0] * M_PER_DEGREE, math.sqrt((north - south) * (east - west) / MAX_CELLS))
    shape = int((north - south) / cell) + 1, int((east - west) / cell) + 1
    _refuse_large(*shape, Path("the grid on the plane"))
    latitude, longitude = _positions(position, (south, west), cell, shape)
    i = np.clip((latitude - grid.south) / grid.cell[0], 0.0, rows - 1.0)
    j = np.clip((longitude - grid.west) / grid.cell[1], 0.0, columns - 1.0)
    return Grid(interpolate(grid.values, i, j), west, south, (cell, cell), degrees=False)


def _extent(grid: Grid, position: Position) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return where [m] the grid begins and ends, northward and eastward, of the origin."""
    latitude, longitude = position(0.0, 0.0)
    rows, columns = grid.values.shape
    north = grid.south + (rows - 1) * grid.cell[0], grid.south
    east = grid.west + (columns - 1) * grid.cell[1], grid.west
    across = M_PER_DEGREE * math.cos(math.radians(latitude))
    return (
        ((north[1] - latitude) * M_PER_DEGREE, (north[0] - latitude) * M_PER_DEGREE),
        ((east[1] - longitude) * across, (east[0] - longitude) * across),
    )


def _positions(
    position: Position, first: tuple[float, float], cell: float, shape: tuple[int, int]
) -> tuple[Numbers, Numbers]:
    """Return latitude and longitude [deg] of every point of a grid on the plane."""
    far = [first[k] + cell * (shape[k] - 1) for k in range(2)]
    norths, easts = (np.linspace(first[k], far[k], LATTICE_KNOTS) for k in range(2))
    knots = np.array([[position(float(n), float(e)) for e in easts] for n in norths])
    i = np.linspace(0.0, LATTICE_KNOTS - 1.0, shape[0])[:, None]
    j = np.linspace(0.0, LATTICE_KNOTS - 1.0, shape[1])[None, :]
    latitude, longitude = (interpolate(knots[:, :, k], i, j) for k in range(2))
    return latitude, longitude


def interpolate(values: Numbers, i: Numbers, j: Numbers) -> Numbers:
    """Return values of a grid between its rows and columns, bilinear."""
    rows, columns = values.shape
    low = np.minimum(np.floor(i).astype(int), rows - 2)
    left_column = np.minimum(np.floor(j).astype(int), columns - 2)
    up, right = i - low, j - left_column
    near = values[low, left_column] * (1.0 - right) + values[low, left_column + 1] * right
    far = values[low + 1, left_column] * (1.0 - right) + values[low + 1, left_column + 1] * right
    result: Numbers = near * (1.0 - up) + far * up
    return result
