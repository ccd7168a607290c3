"""Writes GeoTIFFs with GDAL, and the values that GDAL reads from them. Needs rasterio and numpy.

    make.py fixtures FOLDER     writes the files of this folder
    make.py random FOLDER SEED  writes 300 random files, for a test that runs if there is rasterio
    make.py describe FILE       prints a file's georeference, scales, offsets and no-data value, and how many
                                pixels are masked

NAME.npy holds the values of NAME.tif: scaled and shifted, NaN where GDAL masks them.
places.csv has a line for each file whose place is tested: its name, its EPSG code (0 if there is none), and
x and y at the middles of three pixels: row 0, column 0; row 1, column 0; row 0, column 1.
"""

import csv
import os
import sys
import warnings

import numpy as np
import rasterio
from rasterio.transform import Affine

warnings.simplefilter("ignore")
os.environ |= {"GDAL_PAM_ENABLED": "NO", "GDAL_TIFF_OVR_BLOCKSIZE": "64", "COMPRESS_OVERVIEW": "DEFLATE"}

INTEGERS = {"uint8": (0, 255), "int8": (-128, 127), "uint16": (0, 65535), "int16": (-(2**15), 2**15 - 1)}
INTEGERS |= {"uint32": (0, 2**32 - 1), "int32": (-(2**31), 2**31 - 1), "int64": (-(2**52), 2**52)}
INTEGERS |= {"uint64": (0, 2**52)}


def one_of(rng, *choices):
    return choices[rng.integers(len(choices))]


def numbers(rng, shape, dtype, bits):
    if dtype.startswith("float"):
        smooth = rng.standard_normal() * 1e3 + np.cumsum(rng.standard_normal(shape), axis=1)
        return smooth.astype(dtype)
    low, high = (0, 2**bits - 1) if bits else INTEGERS[dtype]
    if rng.random() < 0.5:
        low, high = max(low, -50), min(high, 50)
    return rng.integers(low, high, shape, endpoint=True).astype(dtype)


def variant(rng, path):
    """Writes a file of a random form. Returns the values that GDAL reads from it, and a description of its form."""
    shape = tuple(int(n) for n in rng.integers(1, 24, 2))
    dtype = one_of(rng, *INTEGERS, "float32", "float64", "float32", "int16", "uint8")
    options = {"BIGTIFF": one_of(rng, "YES", "NO"), "ENDIANNESS": one_of(rng, "LITTLE", "BIG")}
    bits = None
    if dtype in ("uint8", "uint16", "uint32") and rng.random() < 0.4:
        least, most = {"uint8": (1, 8), "uint16": (9, 16), "uint32": (17, 32)}[dtype]
        bits = int(rng.integers(least, most))
        bits += bits == 24
        options["NBITS"] = bits
    if dtype == "float32" and rng.random() < 0.2:
        options["NBITS"] = 16
    compression = one_of(rng, "NONE", "LZW", "DEFLATE", "PACKBITS", "LZW")
    options["COMPRESS"] = compression
    if compression in ("LZW", "DEFLATE") and "NBITS" not in options:
        options["PREDICTOR"] = one_of(rng, 1, 2, 3) if dtype.startswith("float") else one_of(rng, 1, 2)
    if rng.random() < 0.5:
        height, width = (16 * int(n) for n in rng.integers(1, 3, 2))
        options |= {"TILED": "YES", "BLOCKXSIZE": width, "BLOCKYSIZE": height}
    else:
        height, width = int(rng.integers(1, shape[0] + 1)), shape[1]
        options["BLOCKYSIZE"] = height
    has_alpha = dtype in ("uint8", "uint16") and not bits and rng.random() < 0.2
    if has_alpha:
        options |= {"ALPHA": one_of(rng, "YES", "PREMULTIPLIED"), "INTERLEAVE": one_of(rng, "PIXEL", "BAND")}
    options["PHOTOMETRIC"] = one_of(rng, "MINISBLACK", "MINISWHITE")
    options["SPARSE_OK"] = sparse = rng.random() < 0.4
    values = numbers(rng, shape, dtype, bits)
    no_data = None
    if rng.random() < 0.6:
        no_data = values.flat[rng.integers(values.size)].item()
        if dtype.startswith("float"):
            no_data = one_of(rng, no_data, -9999.0, np.nan, -3.4028234663852886e38)
            values[rng.random(shape) < 0.2] = no_data
    mask = rng.random(shape) < 0.7 if not has_alpha and rng.random() < 0.3 else None
    inside = bool(rng.random() < 0.7)
    transform = Affine(10, 0, 5e5, 0, -10, 5e6)
    with rasterio.Env(GDAL_TIFF_INTERNAL_MASK=inside), rasterio.open(
        path, "w", driver="GTiff", height=shape[0], width=shape[1], count=1 + has_alpha, dtype=dtype,
        nodata=no_data, transform=transform, crs="EPSG:32633", **options,
    ) as file:  # fmt: skip
        for top in range(0, shape[0], height):
            for left in range(0, shape[1], width):
                rows, cols = (top, min(top + height, shape[0])), (left, min(left + width, shape[1]))
                if top + left > 0 and sparse and rng.random() < 0.5:
                    continue
                block = values[slice(*rows), slice(*cols)]
                file.write(block, 1, window=(rows, cols))
        if has_alpha:
            file.write((rng.integers(0, 3, shape) * 100).astype(dtype), 2)
        if mask is not None:
            file.write_mask(mask if no_data is None else mask & (values != no_data))
        if rng.random() < 0.4:
            file.scales = (one_of(rng, 0.1, 2.0, -0.25),) * file.count
        if rng.random() < 0.4:
            file.offsets = (one_of(rng, 100.0, -0.5),) * file.count
        if rng.random() < 0.3:
            file.update_tags(note="<a> & 'b'", scale="7")
    if rng.random() < 0.4 and min(shape) > 4 and compression in ("LZW", "DEFLATE") and "NBITS" not in options:
        with rasterio.open(path, "r+") as file:
            file.build_overviews([2])
    form = f"{dtype} {shape} {options} no-data {no_data} mask {mask is not None}"
    return values_of(path), form


def values_of(path):
    """Returns the values that GDAL reads."""
    with rasterio.open(path) as file:
        stored, visible = file.read(1).astype(float), file.read_masks(1) != 0
        values = stored * file.scales[0] + file.offsets[0]
        if (file.scales[0], file.offsets[0]) == (1.0, 0.0):
            values = stored
        if file.nodata is not None:
            # A mask may mark pixels as visible that were never written.
            visible &= file.read(1, masked=True).data != np.array(file.nodata, file.dtypes[0])
    return np.where(visible, values, np.nan)


def save(folder, name, values):
    single = values.astype("f4")
    exact = np.array_equal(single.astype(float), values, equal_nan=True)
    np.save(os.path.join(folder, name + ".npy"), single if exact else values)


def variants(folder, seed, count):
    index, written = 0, 0
    while written < count:
        rng, index = np.random.default_rng([seed, index]), index + 1
        name = f"variant-{written:02}"
        path = os.path.join(folder, name + ".tif")
        for old in (path, path + ".msk"):
            if os.path.exists(old):
                os.remove(old)
        values, form = variant(rng, path)
        if np.isnan(values).all():
            continue
        save(folder, name, values)
        print(name, form)
        written += 1
    for leftover in (f"variant-{written:02}.tif", f"variant-{written:02}.tif.msk"):
        if os.path.exists(os.path.join(folder, leftover)):
            os.remove(os.path.join(folder, leftover))


def grid(folder, name, **options):
    profile = {"height": 5, "width": 7, "count": 1, "dtype": "float32", "crs": "EPSG:32633"}
    profile |= {"driver": "GTiff", "transform": Affine(30, 0, 5e5, 0, -20, 4e6)} | options
    count, shape = profile["count"], (profile["height"], profile["width"])
    values = np.arange(np.prod(shape)).reshape(shape).astype(profile["dtype"])
    path = os.path.join(folder, name + ".tif")
    with rasterio.open(path, "w", **profile) as file:
        for band in range(1, count + 1):
            file.write(values, band)
    return path


def places(folder):
    """Writes files with georeferences of every kind, and their places to places.csv."""
    turned = Affine.translation(5e5, 4e6) @ Affine.rotation(30) @ Affine.scale(30, -20)
    forms = {
        "north-up": {},
        "south-up": {"transform": Affine(30, 0, 5e5, 0, 20, 4e6)},
        "turned": {"transform": turned},
        "sheared": {"transform": Affine(30, 5, 5e5, 0, -20, 4e6)},
        "mirrored": {"transform": Affine(-30, 0, 5e5, 0, -20, 4e6)},
        "degrees": {"crs": "EPSG:4326", "transform": Affine(0.25, 0, 8, 0, -0.25, 47)},
        "us-feet": {"crs": "EPSG:2263"},
        "us-feet-both": {"crs": "EPSG:2263+6360"},
        "metres-and-feet": {"crs": "EPSG:26918+6360"},
        "no-system": {"crs": None},
        "albers": {"crs": "ESRI:102008"},
    }
    with open(os.path.join(folder, "places.csv"), "w", newline="") as table:
        lines = csv.writer(table, lineterminator="\n")
        for name, options in forms.items():
            path = grid(folder, name, **options)
            lines.writerow(place(name, path))
        path = grid(folder, "points")
        with rasterio.open(path, "r+") as file:
            file.update_tags(AREA_OR_POINT="Point")
        lines.writerow(place("points", path))


def place(name, path):
    with rasterio.open(path) as file:
        at = file.transform
        code = None
        if file.crs is not None:
            # The code of a compound system is that of its horizontal system, which the file's keys name.
            horizontal = file.crs.to_wkt().startswith("COMPD_CS")
            code = {"us-feet-both": 2263, "metres-and-feet": 26918}[name] if horizontal else file.crs.to_epsg()
        return [name, code or 0] + [number for col, row in [(0.5, 0.5), (0.5, 1.5), (1.5, 0.5)] for number in at @ (col, row)]


def refused(folder):
    """Writes files that GDAL reads and that the library refuses with a reason."""
    small = {"height": 16, "width": 16}
    grid(folder, "zstd", compress="ZSTD")
    grid(folder, "lerc", compress="LERC")
    grid(folder, "jpeg", compress="JPEG", dtype="uint8", **small)
    grid(folder, "two-bands", count=2)
    grid(folder, "complex", dtype="complex64")
    path = grid(folder, "palette", dtype="uint8")
    with rasterio.open(path, "r+") as file:
        file.write_colormap(1, {index: (index, 0, 0, 255) for index in range(256)})
    path = grid(folder, "nonsense-no-data", nodata=-12345)
    with open(path, "rb") as file:
        bytes = file.read()
    with open(path, "wb") as file:
        file.write(bytes.replace(b"-12345", b"-a2345"))


def describe(path):
    with rasterio.open(path) as file:
        crs = file.crs.to_wkt() if file.crs else "none"
        hidden = int((file.read_masks(1) == 0).sum())
        print(tuple(file.transform)[:6], crs, file.scales, file.offsets)
        print(file.nodata, hidden)


def main():
    task, folder, *rest = sys.argv[1:]
    if task == "fixtures":
        variants(folder, 0, 48)
        places(folder)
        refused(folder)
    elif task == "random":
        variants(folder, int(rest[0]), 300)
    else:
        describe(folder)


if __name__ == "__main__":
    main()
