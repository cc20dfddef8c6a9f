"""Writes archives with markup in their texts, for hostile-archives.test.mjs:
    hostile_archives.py ARCHIVE.h5 FOLDER
copies an archive of dice into the folder, once for each place that has text."""

import pathlib
import shutil
import sys

import h5py
import numpy

SIGNS = "<i onclick=a()>\"'&"


def write_rows(dataset, texts):
    """Writes texts into a table of characters by the table's own type: h5py's would drop the last characters."""
    table = dataset[()]
    for row, text in enumerate(texts):
        table[row] = [text[i:i + 1].encode() for i in range(table.shape[1])]
    dataset.id.write(h5py.h5s.ALL, h5py.h5s.ALL, table, dataset.id.get_type())


def feature_names(file):
    write_rows(file["scene/feature_name"], [SIGNS, "javascript:a()//<b>", "</script><img src=x>"])


def world(file):
    file.attrs["world"] = numpy.bytes_("<script>alert(1)</script>")


def number(file):
    # A slash would create a group.
    file.move("animations/collisions", "animations/<img src=x onerror=alert(1)>")


def unit(file):
    file["animations/end_s"].attrs["units"] = numpy.bytes_("<b>s</b>")


def run(file):
    file.attrs["run_id"] = numpy.bytes_("<script>alert(1)</script>".ljust(64, "x"))


def kind_of_proposal(file):
    write_rows(file["tempering/proposal_kind"], ["<i onclick=a>x"])


def request(file):
    old = file["request"]
    text = old.asstr()[()].encode() + b"\n# <script>alert(1)</script>\n"
    kind = old.id.get_type().copy()
    kind.set_size(len(text) + 1)
    del file["request"]
    new = h5py.h5d.create(file.id, b"request", kind, h5py.h5s.create(h5py.h5s.SCALAR))
    new.write(h5py.h5s.ALL, h5py.h5s.ALL, numpy.array(text, dtype=f"S{len(text) + 1}"), kind)


def main():
    archive, folder = sys.argv[1:]
    for change in [feature_names, world, number, unit, run, kind_of_proposal, request]:
        copy = pathlib.Path(folder) / f"{change.__name__}.h5"
        shutil.copy(archive, copy)
        with h5py.File(copy, "r+") as file:
            change(file)


main()
