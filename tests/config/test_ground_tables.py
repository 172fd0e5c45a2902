"""The ground in an exercise: its table, grids from files, and what is refused."""

import gzip
import re
import struct
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.places import DATA
from helpers.sessions import start_plan

from trainer.config.exercise.exercise import parse_exercise
from trainer.config.files import ConfigError, Position, reading_recorded, remembering
from trainer.config.world.bottom import (
    LAND_DEPTH_M,
    Bottom,
    depths_at,
    is_charted,
    land_near,
    read_bottom,
)
from trainer.config.world.soundings import (
    MAX_CELLS,
    Grid,
    on_the_plane,
    read_as_kept,
    read_grid,
)
from trainer.io.chart import Chart
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run

HEAD = "ncols 2\nnrows 2\nxllcenter 0\nyllcenter 0\ncellsize 100\n"
SAMPLES = "10 20\n30 40\n"


@pytest.fixture
def asc(tmp_path: Path) -> Path:
    """Return an ESRI ASCII grid of two by two."""
    path = tmp_path / "canyon.asc"
    path.write_text(HEAD + SAMPLES)
    return path


def ground(path: Path, **table: Any) -> Bottom:
    """Return the ground of a table [bottom] of an exercise beside ``path``."""
    return read_bottom(table, Position("drill.toml", "bottom"), path.parent / "drill.toml")


def refused(path: Path, **table: Any) -> str:
    """Return why a table [bottom] is refused."""
    with pytest.raises(ConfigError) as error:
        ground(path, **table)
    assert all("\n" not in each for each in error.value.problems)
    return str(error.value)


# ESRI ASCII


def test_depths_are_those_between_the_samples_and_beyond_the_end_those_of_the_edge(
    asc: Path,
) -> None:
    bottom = ground(asc, grid=asc.name, values="depth", tide_m=1.0)
    north, east = np.array([50.0, -900.0, 900.0, 50.0]), np.array([50.0, -900.0, 50.0, 900.0])
    assert depths_at(bottom, north, east).tolist() == [26.0, 31.0, 16.0, 31.0]


def test_a_corner_is_half_a_cell_from_the_sample_whatever_the_case_and_line_ends(
    tmp_path: Path,
) -> None:
    path = tmp_path / "a.asc"
    text = "NCOLS 2\r\nnRows 2\r\nXLLCORNER -50\r\nYllCorner 150\r\nCellSize 100\r\n"
    path.write_bytes(f"{text}NODATA_value -1\r\n10 20 30\r\n-1".encode())
    grid = read_grid(path)
    assert (grid.west, grid.south) == (0.0, 200.0)
    assert np.isnan(grid.values[0, 1])
    assert grid.values[1].tolist() == [10.0, 20.0]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (HEAD.replace("ncols", "columns") + SAMPLES, "columns: no such keyword"),
        (HEAD + "nrows 2\n" + SAMPLES, "nrows is given twice"),
        (HEAD.replace("cellsize 100\n", "") + SAMPLES, "lacks CELLSIZE"),
        (HEAD.replace("cellsize 100", "cellsize 0") + SAMPLES, "CELLSIZE = 0: must be above 0"),
        (HEAD.replace("nrows 2", "nrows 2.5") + SAMPLES, "NROWS = 2.5: must be a whole number"),
        (HEAD.replace("xllcenter", "xllcorner") + SAMPLES, "both of one kind"),
        (HEAD + "10 20 30", "has 3 samples; NROWS times NCOLS is 4"),
        (HEAD + "10 20 30 40 50", "has 5 samples"),
        (HEAD + "10 20 x 40", 'sample 3 = "x": is no number'),
        (HEAD + "10 inf 30 40", "sample 2 = inf: must be finite, or nan"),
        (HEAD + "10 12000 12001 36000", "sample 3 = 12001: no sea is deeper than 12000 m: is the"),
        (HEAD + "NODATA_value none\n" + SAMPLES, "NODATA_VALUE = none: must be a finite number"),
        (
            HEAD.replace("ncols 2", "ncols 4001").replace("nrows 2", "nrows 1000"),
            f"{MAX_CELLS} at most",
        ),
        (HEAD.replace("nrows 2", "nrows 1") + "10 20", "at least 2 x 2"),
    ],
)
def test_a_bad_grid_is_named_with_what_is_wrong(asc: Path, text: str, told: str) -> None:
    asc.write_text(text)
    said = refused(asc, grid=asc.name, values="depth")
    assert told in said
    assert said.startswith('drill.toml: [bottom] grid = "canyon.asc": ')
    assert str(asc) in said


def test_a_grid_that_is_not_there_or_no_text_is_refused(asc: Path) -> None:
    assert "No such file" in refused(asc, grid="none.asc", values="depth")
    asc.write_bytes(b"ncols \xff")
    assert "is not UTF-8" in refused(asc, grid=asc.name, values="depth")


# The table


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ({}, "give depth_m, or grid with values"),
        ({"depth_m": 100, "grid": "canyon.asc", "values": "depth"}, "give depth_m, or grid"),
        ({"grid": "canyon.asc"}, "lacks values"),
        ({"depth_m": 100, "values": "depth"}, 'values = "depth": does not go with depth_m'),
        ({"depth_m": 100, "slope_percent": 3}, "give slope_percent and deepens_deg, or neither"),
        (
            {"grid": "canyon.asc", "values": "depth", "slope_percent": 1, "deepens_deg": 0},
            "slope_percent = 1.0: does not go with a grid",
        ),
        ({"depth_m": 0}, "depth_m = 0: must be above 0"),
        ({"depth_m": 100, "kind": "clay"}, 'kind = "clay"'),
        ({"depth_m": 100, "grounding": "stop"}, 'grounding = "stop"'),
        ({"depth_m": 100, "breakout_t": 5}, 'only kind = "mud" holds a boat'),
        ({"depth_m": 100, "tide_m": 50}, "tide_m = 50: must be -20 to 20 m"),
        ({"deph_m": 100}, "nearest is depth_m"),
    ],
)
def test_a_bad_table_is_named_with_key_value_and_limit(
    asc: Path, table: dict[str, Any], told: str
) -> None:
    assert told in refused(asc, **table)


def test_heights_are_depths_with_the_sign_turned_and_the_tide_is_added(asc: Path) -> None:
    depth = ground(asc, grid=asc.name, values="depth", tide_m=2).depth.values
    height = ground(asc, grid=asc.name, values="height", tide_m=2).depth.values
    assert depth[0].tolist() == [32.0, 42.0]
    assert height[0].tolist() == [-28.0, -38.0]


def test_a_plane_deepens_the_way_it_says(asc: Path) -> None:
    plane = ground(asc, depth_m=100, slope_percent=10, deepens_deg=90, tide_m=1).depth
    assert plane.values[0].tolist() == pytest.approx([101.0, 101.1])
    assert plane.values[1, 0] == pytest.approx(101.0)


def test_a_sample_without_a_value_is_land_and_how_near_it_is_can_be_told(asc: Path) -> None:
    asc.write_text(HEAD + "10 20 -9999 40")
    found = ground(asc, grid=asc.name, values="depth")
    assert found.depth.values[0].tolist() == [LAND_DEPTH_M, 40.0]
    assert land_near(found, 0.0, 30.0) == 30.0
    assert land_near(found, 5000.0, 0.0) == np.inf
    assert is_charted(found, 100.0, 100.0)
    assert not is_charted(found, 101.0, 0.0)


@pytest.mark.parametrize(
    "text",
    [
        "NODATA_value nan\n10 20 nan 40",
        "nan 20 30 40",
        "10 20 -9999 NaN",
        "NODATA_value -9999\n10 20 -9999.0 40",
        "NODATA_value -9.999e3\n10 20 -9999 40",
        "NODATA_value -3.4028234663852886e+38\n10 20 -3.40282e+38 40",
        "NODATA_value -9999.9\n10 20 -9999.900390625 40",
        "NODATA_value -1\n10 20 -1.000000 40",
        "NODATA_value -1\n10 20 1e20 40",
        "NODATA_value -1\n10 20 -32768 -32768",
    ],
)
def test_a_sample_without_a_value_is_none_however_it_is_printed(asc: Path, text: str) -> None:
    asc.write_text(HEAD + text)
    values = read_grid(asc).values[::-1].ravel()
    lacking = [word.lower() not in ("10", "20", "30", "40") for word in text.split()[-4:]]
    assert np.isnan(values).tolist() == lacking
    known = ~np.isnan(values)
    assert values[known].tolist() == np.array([10.0, 20.0, 30.0, 40.0])[known].tolist()


def test_a_depth_of_twelve_thousand_metres_and_one_beside_the_value_of_none_are_depths(
    asc: Path,
) -> None:
    asc.write_text(HEAD + "NODATA_value -9999\n12000 -12000 -9990 0")
    assert not np.isnan(read_grid(asc).values).any()


def test_a_stranger_s_grid_of_nan_is_read_once_it_is_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "nan.asc"
    path.write_bytes((DATA / "strangers" / "nan.asc.gz").read_bytes())
    assert "is packed: gunzip it" in refused(path, grid=path.name, values="depth")
    path.write_bytes(gzip.decompress(path.read_bytes()))
    found = ground(path, grid=path.name, values="depth")
    assert np.isnan(found.known.values).sum() == 1 if found.known else False
    assert found.depth.values[-1, 0] == LAND_DEPTH_M
    assert found.depth.values[0, 0] == 120.5


# What is kept in a recording


def test_a_recorded_grid_needs_no_file_and_is_the_same_to_the_bit(tmp_path: Path) -> None:
    path = tmp_path / "a.asc"
    values = np.random.default_rng(3).normal(100.0, 30.0, (40, 30))
    rows = "\n".join(" ".join(map(repr, row.tolist())) for row in values)
    path.write_text(f"ncols 30\nnrows 40\nxllcenter 0\nyllcenter 0\ncellsize 7\n{rows}\n")
    with remembering() as texts:
        first = read_grid(path)
    path.unlink()
    with reading_recorded(texts):
        again = read_grid(path)
    assert again.values.tobytes() == first.values.tobytes()
    assert again.values.tobytes() == values[::-1].tobytes()
    assert (again.west, again.south, again.cell) == (first.west, first.south, first.cell)


def test_today_s_file_is_compared_with_the_one_recorded(asc: Path) -> None:
    with remembering() as texts:
        read_grid(asc)
    (kept,) = texts.values()
    assert read_as_kept(asc, kept) == kept
    asc.write_text(HEAD + "10 20 30 41")
    assert read_as_kept(asc, kept) != kept


# Degrees


def test_a_grid_in_degrees_is_sampled_where_the_chart_has_it() -> None:
    chart = Chart(54.0, 10.0)
    latitudes, longitudes = 53.9 + 0.01 * np.arange(21), 9.8 + 0.01 * np.arange(41)
    values = latitudes[:, None] + 10.0 * longitudes[None, :]  # linear: bilinear is exact
    grid = Grid(values, 9.8, 53.9, (0.01, 0.01), degrees=True)
    plane = on_the_plane(grid, chart.position)
    for i, j in ((3, 5), (10, 10), (15, 20)):
        north = plane.south + i * plane.cell[0]
        latitude, longitude = chart.position(north, plane.west + j * plane.cell[1])
        assert plane.values[i, j] == pytest.approx(latitude + 10.0 * longitude, abs=1e-5)


def test_an_esri_grid_with_origin_deg_is_in_degrees(tmp_path: Path) -> None:
    path = tmp_path / "a.asc"
    path.write_text(
        "ncols 3\nnrows 3\nxllcenter 9.99\nyllcenter 53.99\ncellsize 0.01\n" + "80 " * 9
    )
    found = ground(path, grid=path.name, values="depth", origin_deg=[54, 10])
    assert found.depth.cell[0] == pytest.approx(1111.3, abs=1.0)
    assert is_charted(found, 0.0, 0.0)
    assert found.depth.values == pytest.approx(80.0)


# GeoTIFF


def tiff(folder: Path, values: Any, **more: Any) -> Path:
    """Write a GeoTIFF, metres or degrees by ``keys``, its first pixel's corner at 0, 200."""
    tifffile = pytest.importorskip("tifffile")
    keys = more.pop("keys", (1024, 0, 1, 1, 1025, 0, 1, 1))
    scale, corner = more.pop("scale", 100.0), more.pop("corner", (0.0, 200.0))
    tags = [
        (33550, "d", 3, (scale, scale, 0.0), True),
        (33922, "d", 6, (0.0, 0.0, 0.0, *corner, 0.0), True),
        (34735, "H", 4 + len(keys), (1, 1, 0, len(keys) // 4, *keys), True),
    ]
    tags += [(42113, "s", 0, more.pop("absent"), True)] if "absent" in more else []
    tags += [(42112, "s", 0, more.pop("gdal"), True)] if "gdal" in more else []
    path = folder / "a.tif"
    form = more.pop("form", np.float32)
    tifffile.imwrite(path, np.asarray(values, form), extratags=tags, **more)
    return path


@pytest.mark.parametrize(
    ("value", "more"), [(-3.4028235e38, {"absent": "-3.40282e+38"}), (-32768, {}), (-9999.9, {})]
)
def test_a_geotiff_s_sample_without_a_value_is_none_however_it_is_printed(
    tmp_path: Path, value: float, more: dict[str, str]
) -> None:
    path = tiff(tmp_path, [[10, 20], [30, value]], **(more or {"absent": f"{value:g}"}))
    assert np.isnan(read_grid(path).values).tolist() == [[False, True], [False, False]]
    if value < -12000:
        tiff(tmp_path, [[10, 20], [30, value]])
        assert np.isnan(read_grid(path).values).sum() == 1


def packed(data: bytes) -> bytes:
    """Return bytes by PackBits: runs of the same as (257 - length, byte), all else as it is."""
    found = b""
    for run in re.finditer(rb"(?s)(.)\1{2,127}|(?:(.)(?!\2\2)){1,128}", data):
        same, length = run[1], len(run[0])
        found += bytes([257 - length]) + same if same else bytes([length - 1]) + run[0]
    return found


def test_packbits_are_unpacked(tmp_path: Path) -> None:
    values = np.array([[0, 0], [30, 40]], np.float32)
    path = tiff(tmp_path, values)
    strip = values.tobytes()
    assert packed(b"abccccd") == b"\x01ab\xfdc\x00d"
    assert len(packed(strip)) < 2 * len(strip)
    data = path.read_bytes().replace(strip, packed(strip).ljust(len(strip), b"\x80"))
    path.write_bytes(coded(data, 32773, len(packed(strip))))
    assert read_grid(path).values.tolist() == [[30.0, 40.0], [0.0, 0.0]]


@pytest.mark.parametrize("compression", [None, "zlib", "lzma"])
def test_a_geotiff_is_the_same_grid_as_an_esri_grid(
    tmp_path: Path, compression: str | None
) -> None:
    path = tiff(tmp_path, [[10, 20], [30, -5]], absent="-5", compression=compression)
    grid = read_grid(path)
    assert (grid.west, grid.south, grid.cell, grid.degrees) == (50.0, 50.0, (100.0, 100.0), False)
    assert grid.values[1].tolist() == [10.0, 20.0]
    assert np.isnan(grid.values[0, 1])


SCALED = (  # as GDAL writes it
    '<GDALMetadata>\n  <Item name="OFFSET" sample="0" role="offset">{offset}</Item>\n'
    '  <Item name="SCALE" sample="0" role="scale">{scale}</Item>\n</GDALMetadata>\n'
)


def test_a_geotiff_of_decimetres_has_metres_by_its_scale_and_offset(tmp_path: Path) -> None:
    said = SCALED.format(scale="0.1", offset="-2.5")
    values = [[1000, 20000], [300, -32768]]
    path = tiff(tmp_path, values, form=np.int16, absent="-32768", gdal=said)
    assert read_grid(path).values[1].tolist() == [97.5, 1997.5]
    assert read_grid(path).values[0, 0] == 27.5
    assert np.isnan(read_grid(path).values[0, 1])


@pytest.mark.parametrize(("scale", "told"), [("0", "must not be 0"), ("ten", "finite number")])
def test_a_geotiff_with_a_scale_that_is_none_is_refused(
    scale: str, told: str, tmp_path: Path
) -> None:
    path = tiff(tmp_path, [[1, 2], [3, 4]], gdal=SCALED.format(scale=scale, offset="0"))
    assert f"SCALE = {scale}: must" in refused(path, grid=path.name, values="depth")
    assert told in refused(path, grid=path.name, values="depth")


def test_an_esri_grid_whose_cells_are_not_square_has_a_size_for_each_way(asc: Path) -> None:
    asc.write_text(HEAD.replace("cellsize 100", "dx 100\ndy 50") + SAMPLES)
    assert read_grid(asc).cell == (50.0, 100.0)
    asc.write_text(HEAD.replace("cellsize 100", "dx 100\ndy 0") + SAMPLES)
    assert "DY = 0: must be above 0" in refused(asc, grid=asc.name, values="depth")
    asc.write_text(HEAD.replace("cellsize 100", "dx 100") + SAMPLES)
    assert "lacks DY" in refused(asc, grid=asc.name, values="depth")


def test_a_geotiff_of_points_has_its_tie_at_the_sample(tmp_path: Path) -> None:
    path = tiff(tmp_path, [[1, 2], [3, 4]], keys=(1024, 0, 1, 1, 1025, 0, 1, 2))
    assert (read_grid(path).west, read_grid(path).south) == (0.0, 100.0)


def test_a_geotiff_in_degrees_needs_the_origin(tmp_path: Path) -> None:
    keys = (1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326)
    path = tiff(tmp_path, np.full((4, 4), 70.0), keys=keys, scale=0.01, corner=(9.98, 54.02))
    assert "give origin_deg" in refused(path, grid=path.name, values="depth")
    found = ground(path, grid=path.name, values="depth", origin_deg=[54, 10])
    assert is_charted(found, 0.0, 0.0)


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ((1024, 0, 1, 1, 3072, 0, 1, 32633), "EPSG:32633"),
        ((1024, 0, 1, 2, 2048, 0, 1, 4258), "EPSG:4258"),
        ((1024, 0, 1, 1, 3072, 0, 1, 32767, 3076, 0, 1, 9002), "EPSG:9002"),
    ],
)
def test_another_reference_system_is_refused_by_name(
    tmp_path: Path, keys: tuple[int, ...], told: str
) -> None:
    path = tiff(tmp_path, [[1, 2], [3, 4]], keys=keys)
    said = refused(path, grid=path.name, values="depth")
    assert told in said
    assert "gdalwarp -t_srs EPSG:4326" in said


def coded(data: bytes, code: int, length: int | None = None) -> bytes:
    """Return a TIFF of one strip whose tags say another compression, and length of the strip."""
    for tag, value in ((259, code), (279, length)):
        kind = 3 if tag == 259 else 4
        entry = re.search(re.escape(struct.pack("<HHI", tag, kind, 1)), data)
        assert entry
        if value is not None:
            data = data[: entry.end()] + struct.pack("<I", value) + data[entry.end() + 4 :]
    return data


@pytest.mark.parametrize(
    ("code", "told"),
    [
        (5, "LZW"),
        pytest.param(
            *(50000, "is compressed by ZSTD, which needs Python 3.14"),
            marks=pytest.mark.skipif(sys.version_info >= (3, 14), reason="this Python reads zstd"),
        ),
    ],
)
def test_a_compression_that_is_not_read_is_refused_with_how_to_convert(
    tmp_path: Path, code: int, told: str
) -> None:
    path = tiff(tmp_path, [[1, 2], [3, 4]])
    path.write_bytes(coded(path.read_bytes(), code))
    said = refused(path, grid=path.name, values="depth")
    assert told in said
    assert "COMPRESS=DEFLATE" in said


def test_a_damaged_geotiff_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("tifffile")
    path = tmp_path / "a.tif"
    path.write_bytes(b"II*\0" + b"\xff" * 40)
    assert "is no GeoTIFF that can be read" in refused(path, grid=path.name, values="depth")


# A start


def exercise(path: Path, bottom: str, initial: str = "[initial]\ndepth_m = 5") -> Path:
    """Write an exercise over a ground; return its path."""
    drill = path.parent / "drill.toml"
    text = 'schema = "exercise/1"\nname = "Ground"\nbriefing = "Go."\n'
    drill.write_text(f"{text}{initial}\n[bottom]\n{bottom}\n")
    return drill


@pytest.mark.parametrize(
    ("bottom", "heading", "told"),
    [
        ("depth_m = 68", "[initial]\ndepth_m = 60", "under the keel: 5 m at least"),
        ("depth_m = 90", "step_s = 2\n[initial]\ndepth_m = 60", "with a step of 2 s: 1 s at most"),
        ('grid = "far.asc"\nvalues = "depth"', "[initial]\ndepth_m = 5", "the boat starts off it"),
        (
            'grid = "land.asc"\nvalues = "depth"',
            "[initial]\ndepth_m = 5",
            "has no value 200 m from the start: 2000 m at least",
        ),
    ],
)
def test_a_start_over_bad_ground_is_refused(
    asc: Path, bottom: str, heading: str, told: str
) -> None:
    far = HEAD.replace("yllcenter 0", "yllcenter 500") + "90 90 90 90"
    (asc.parent / "far.asc").write_text(far)
    land = "ncols 3\nnrows 3\nxllcenter -200\nyllcenter -200\ncellsize 200\n"
    (asc.parent / "land.asc").write_text(land + "90 -9999 90 90 90 90 90 90 90")
    drill = exercise(asc, bottom, heading)
    plan = plan_run(RunOptions(exercise=str(drill)))
    with pytest.raises(ConfigError) as error:
        start_plan(plan)
    assert told in str(error.value)


SHIP = '[[contact]]\nname = "{name}"\ntype = "tanker"\nspeed_kn = 10\npoints = {points}\n'


def test_a_ship_whose_way_has_too_little_water_is_named_with_the_place(asc: Path) -> None:
    slope = "depth_m = 60\nslope_percent = 1\ndeepens_deg = 180\n"  # shoals going north
    ships = SHIP.format(name="off", points="[[0, 900], [4600, 900]]")
    ships += SHIP.format(name="on", points="[[0, 1500], [5000, 1500]]")
    drill = exercise(asc, slope + ships, "[initial]\ndepth_m = 20")
    with pytest.raises(ConfigError) as error:
        parse_exercise(drill.read_text(), drill)
    assert "[contact[1]] points: 13.0 m of water at [4700, 1500]" in str(error.value)
    assert "a tanker draws 11 m, so 13.2 m at least" in str(error.value)
    assert "contact[0]" not in str(error.value)


def test_beyond_the_end_of_a_chart_no_ship_is_aground(asc: Path) -> None:
    ships = SHIP.format(name="far", points="[[9000, -9000], [9500, -9500]]")
    drill = exercise(asc, f'grid = "canyon.asc"\nvalues = "depth"\n{ships}')
    assert parse_exercise(drill.read_text(), drill).world["contact"]
