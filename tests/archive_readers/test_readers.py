#!/usr/bin/python3
"""Checks archives by xarray and h5py against the CSV export, and recomputes their digests.

    test_readers.py ARCHIVE [CSV_FOLDER]     checks an archive (of any world)
    test_readers.py --writer PROGRAM         writes sample archives with PROGRAM and checks them

Goal: every installed engine reads the right dimensions, coordinates, booleans and values. Method: compare
each engine's values with h5py's, and h5py's values with the CSV. Compute the digest with h5py alone, as
docs/ARCHIVE_FORMAT.md specifies, and compare it with the stored digest.
"""

import csv
import hashlib
import importlib.util
import pathlib
import struct
import subprocess
import sys
import tempfile

import h5py
import numpy as np
import xarray

GROUPS = ("posterior", "sample_stats", "replicas", "tempering", "animations", "finds", "scene",
          "prior", "sample_stats_prior")
BARE = b"This is a netCDF dimension but not a netCDF variable."
HIDDEN = {"CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST", "_Netcdf4Dimid",
          "_Netcdf4Coordinates", "_Encoding"}
INDEX = {"posterior": ("chain", "draw"), "sample_stats": ("chain", "draw"),
         "replicas": ("chain", "replica"), "animations": ("animation",), "segments": ("segment",),
         "finds": ("animation",), "find_segments": ("segment",), "prior": ("chain", "draw"),
         "sample_stats_prior": ("chain", "draw"), "features": ("feature",), "parts": ("part",),
         "points": ("point",), "find_points": ("point",)}
GROUP_OF = {"segments": "animations", "find_segments": "finds", "features": "scene",
            "parts": "scene", "points": "animations", "find_points": "finds"}
LEFT_OUT = ("content_digest", "inference_library_version", "results_version", "run_id")


def check(condition, *what):
    if not condition:
        raise AssertionError(" ".join(str(word) for word in what))


def groups_of(file):
    return [group for group in GROUPS if group in file]


def is_bare(dataset):
    return bytes(dataset.attrs.get("NAME", b"")).startswith(BARE)


def is_bool(dataset):
    return bytes(dataset.attrs.get("dtype", b"")) == b"bool"


def is_text(dataset):
    return dataset.dtype.kind == "S"


def dims_of(dataset):
    """Names of a dataset's dimensions, from its dimension scales."""
    if bytes(dataset.attrs.get("CLASS", b"")) == b"DIMENSION_SCALE":
        return (dataset.name.rsplit("/", 1)[1],)
    rank = dataset.ndim - 1 if is_text(dataset) and dataset.ndim else dataset.ndim
    return tuple(dataset.dims[i][0].name.rsplit("/", 1)[1] for i in range(rank))


def values_of(dataset):
    """Values with booleans as bool and text as str."""
    data = dataset[()]
    if is_text(dataset):
        if dataset.ndim == 0:
            return bytes(data).decode()
        rows = [b"".join(row).decode() for row in data.reshape(-1, data.shape[-1])]
        return np.array(rows, dtype=object)
    return data.astype(bool) if is_bool(dataset) else data


def datasets_of(group):
    return {name: item for name, item in group.items()
            if isinstance(item, h5py.Dataset) and not is_bare(item)}


def same(a, b):
    a, b = np.asarray(a), np.asarray(b)
    if a.dtype.kind == "f":
        return a.shape == b.shape and np.array_equal(a, b, equal_nan=True)
    return a.shape == b.shape and bool(np.all(a == b))


def check_engine(path, file, engine):
    root = xarray.open_dataset(path, engine=engine)
    check(root.attrs["format"] == "sleight-archive", engine, "format")
    check(int(root.attrs["format_version"]) == 3, engine, "format_version")
    request = root["request"].values.item()
    request = request.decode() if isinstance(request, bytes) else request
    check(request == values_of(file["request"]), engine, "request", request)
    for group in groups_of(file):
        with xarray.open_dataset(path, engine=engine, group=group) as data:
            data.load()
            expected = datasets_of(file[group])
            check(set(data.variables) == set(expected), engine, group, set(data.variables))
            for name, dataset in expected.items():
                variable, dims = data[name], dims_of(dataset)
                check(variable.dims == dims, engine, group, name, variable.dims, dims)
                check(same(variable.values, values_of(dataset)), engine, group, name)
                check((variable.dtype == bool) == is_bool(dataset), engine, group, name, "bool")
                check(all(dim in data.coords for dim in dims), engine, group, name, "coordinates")
                check("long_name" in variable.attrs, engine, group, name, "long_name")
    stats = xarray.open_dataset(path, engine=engine, group="sample_stats")
    kinds = [str(kind) for kind in stats["proposal_kind"].values]
    check(stats["satisfied"].dtype == bool, engine, "satisfied")
    by_kind = [stats["accepted"].sel(proposal_kind=kind).values for kind in kinds]
    check(same(np.stack(by_kind, axis=-1), file["sample_stats/accepted"][()]), engine, "by kind")


def check_csv(folder, file):
    for table, index in INDEX.items():
        group = file[GROUP_OF.get(table, table)]
        with open(folder / f"{table}.csv", newline="") as stream:
            rows = list(csv.reader(stream))
        header, rows = rows[0], rows[1:]
        check(header[:len(index)] == list(index), table, header[:3])
        coordinates = np.meshgrid(*(values_of(group[dim]) for dim in index), indexing="ij")
        check(len(rows) == coordinates[0].size, table, "rows")
        place = 0
        for array in coordinates:
            check([int(row[place]) for row in rows] == list(array.reshape(-1)), table, "index")
            place += 1
        columns = {name: d for name, d in datasets_of(group).items()
                   if dims_of(d)[:len(index)] == index and dims_of(d) != (name,)}
        seen = {name: [] for name in columns}
        for i in range(place, len(header)):
            name = header[i].split("[")[0]
            kind = str if is_text(columns[name]) else float
            seen[name].append([kind(row[i]) for row in rows])
        for name, dataset in columns.items():
            if is_text(dataset):
                check(seen[name] == [list(values_of(dataset))], table, name)
                continue
            flat = dataset[()].astype(float).reshape(len(rows), -1)
            found = np.array(seen[name], dtype=float).reshape(-1, len(rows)).T
            check(same(found, flat), table, name)


def attribute_line(place, name, attribute):
    if attribute.dtype.kind == "S":
        return f"attribute {place} {name} text {hashlib.sha256(bytes(attribute)).hexdigest()}"
    if attribute.dtype.kind == "f":
        return f"attribute {place} {name} f64 {struct.pack('>d', float(attribute)).hex()}"
    return f"attribute {place} {name} i64 {int(attribute)}"


def dataset_hash(dataset):
    if is_text(dataset):
        values = values_of(dataset)
        texts = [values] if isinstance(values, str) else values
        packed = b"".join(struct.pack("<Q", len(t.encode())) + t.encode() for t in texts)
        return hashlib.sha256(packed).hexdigest()
    data = np.array(dataset[()])
    if data.dtype.kind == "f":
        data = np.where(np.isnan(data), np.frombuffer(struct.pack("<Q", 0x7ff8 << 48), "<f8"), data)
    return hashlib.sha256(np.ascontiguousarray(data).tobytes()).hexdigest()


def digest_of(file):
    lines = []
    for place in ["/"] + [f"/{group}" for group in groups_of(file)]:
        lines.append(f"group {place}")
        for name, value in file[place].attrs.items():
            if place != "/" or name not in LEFT_OUT:
                lines.append(attribute_line(place, name, value))
        for name, dataset in datasets_of(file[place]).items():
            path = f"{place.rstrip('/')}/{name}"
            for key, value in dataset.attrs.items():
                if key not in HIDDEN and not (key == "dtype" and is_bool(dataset)):
                    lines.append(attribute_line(path, key, value))
            kind = ("bool" if is_bool(dataset) else "text" if is_text(dataset) else
                    dataset.dtype.kind + str(8 * dataset.dtype.itemsize))
            shape = ",".join(f"{d}={n}" for d, n in zip(dims_of(dataset), dataset.shape))
            lines.append(f"dataset {path} {kind} {shape or 'scalar'} {dataset_hash(dataset)}")
    text = "sleight-archive digest 1\n" + "".join(line + "\n" for line in
                                                  sorted(lines, key=str.encode))
    return hashlib.sha256(text.encode()).hexdigest()


def check_archive(path, csv_folder=None):
    engines = [engine for engine, module in (("netcdf4", "netCDF4"), ("h5netcdf", "h5netcdf"))
               if importlib.util.find_spec(module)]
    check(engines, "neither netCDF4 nor h5netcdf is installed (deploy/install-deps)")
    with h5py.File(path, "r") as file:
        stored = bytes(file.attrs["content_digest"]).decode()
        check(digest_of(file) == stored, path, "digest", digest_of(file), stored)
        for engine in engines:
            check_engine(path, file, engine)
        if csv_folder:
            check_csv(pathlib.Path(csv_folder), file)
    print(f"{path}: read alike by h5py, {', '.join(engines)}" + (" and CSV" if csv_folder else ""))


def check_samples(writer):
    """Checks archives from a single scan to several chunks per dataset."""
    for scans in (1, 2, 101, 20000):
        with tempfile.TemporaryDirectory() as folder:
            path = f"{folder}/sample.h5"
            subprocess.run([writer, path, str(scans), folder], check=True,
                           stdout=subprocess.DEVNULL)
            check_archive(path, folder)
            check_negative(path)


def check_negative(path):
    """The checker can fail: one changed value must break the digest."""
    with h5py.File(path, "r+") as file:
        file["replicas/log_prior"][0, 0] += 1
    try:
        check_archive(path)
    except AssertionError:
        return
    raise AssertionError("a changed value went unnoticed")


if __name__ == "__main__":
    if len(sys.argv) == 3 and sys.argv[1] == "--writer":
        check_samples(sys.argv[2])
    elif len(sys.argv) in (2, 3):
        check_archive(*sys.argv[1:])
    else:
        sys.exit(__doc__)
