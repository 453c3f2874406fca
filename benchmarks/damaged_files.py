"""Damaged files: each is read, or refused in one short sentence.

    python benchmarks/damaged_files.py [--count N] [--first SEED] [--limit SECONDS] [--failures FOLDER]
                                       [--only NAME ...]

Small files of every format that is read, nets, grids, horizons and checkpoints are damaged at random: bytes
are changed, removed, doubled and inserted, the end is cut off, and numbers become others.  Anything but a
result or a refusal is counted: other exceptions, warnings, more than so many seconds of the processor, more
than a few gigabytes of memory, and refusals that are long, in several lines, or hold control characters.
"""

import argparse
import collections
import gzip
import json
import os
import random
import re
import resource
import signal
import struct
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np

from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidMetric, InvalidParameter, MeshNote
from isoembed.gluing import unfold
from isoembed.io import FileError, read_metric, write_surface
from isoembed.io.net import read_net, write_net
from isoembed.io.registry import SURFACE_ENDINGS
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.relativity.horizons.grid_file import read_grid_data
from isoembed.relativity.horizons.horizon_file import read_horizon
from isoembed.relativity.series.slice_files import read_slice

MEMORY = 4 << 30  # bytes more than at the start
LONGEST = 400  # characters of a refusal, without the name of the file
NUMBERS = (b"nan", b"inf", b"-1", b"0", b"1e400", b"-1e300", b"999999999999", b"1e-320", b"\xd9\xa3", b"")
NUMBER = re.compile(rb"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
WORDS = (0, 1, 2**31 - 1, 2**31, 2**32 - 1, 2**63, 2**64 - 1)


class TooSlow(BaseException):
    """The limit of seconds is over."""


def solid():
    """An octahedron of unequal axes."""
    points = np.array([[1.5, 0, 0], [-1.5, 0, 0], [0, 1.25, 0], [0, -1.25, 0], [0, 0, 1], [0, 0, -1]])
    faces = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
    return points, faces


def sources(folder):
    """Names, contents and readers of undamaged files."""
    points, faces = solid()
    surface = Embedding(PolyhedralMetric.from_mesh(points, faces), points, method="given", tolerance=1e-10)
    found = []

    def add(name, content, read=read_metric):
        found.append((name, content if isinstance(content, bytes) else content.encode(), read))

    def add_file(name, read=read_metric):
        add(name, (folder / name).read_bytes(), read)

    for ending in SURFACE_ENDINGS:
        write_surface(folder / f"written{ending}", surface)
        add_file(f"written{ending}")
    rows = np.zeros(8, np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]))
    rows["corners"] = points[faces]
    add("binary.stl", bytes(80) + struct.pack("<I", 8) + rows.tobytes())
    xyz = "\n".join(" ".join(map(str, p)) for p in points)
    plain = "\n".join("3 {} {} {}".format(*f) for f in faces)
    head = "element vertex 6\nproperty double x\nproperty double y\nproperty double z\nelement face 8\n"
    add(
        "text.ply",
        f"ply\nformat ascii 1.0\n{head}property list uchar int vertex_index\nend_header\n{xyz}\n{plain}\n",
    )
    strip = "element tristrips 1\nproperty list int int vertex_indices\n"
    corners = " ".join("{} {} {} -1".format(*f) for f in faces)
    add(
        "strips.ply",
        f"ply\nformat ascii 1.0\n{head.split('element face')[0]}{strip}end_header\n{xyz}\n32 {corners}\n",
    )
    add(
        "edges.off",
        f"COFF\n6 9 12\n{xyz.replace(chr(10), ' 255 0 0 255' + chr(10))} 0 0 0 255\n{plain}\n2 0 1\n",
    )
    negative = "\n".join("f {}/1 {}/1 \\\n {}/1".format(*(f - 6)) for f in faces)
    add("negative.obj", "".join(f"v {x}\n" for x in xyz.splitlines()) + f"g a\nvt 0 0\n{negative}\n")
    polydata = f"\nDATASET POLYDATA\nPOINTS 6 double\n{xyz}\n"
    add("old.vtk", f"# vtk DataFile Version 3.0\ntitle\nASCII{polydata}POLYGONS 8 32\n{plain}\n")
    ends = " ".join(str(3 * k) for k in range(9))
    corners = " ".join(map(str, faces.ravel()))
    add(
        "new.vtk",
        f"# vtk DataFile Version 5.1\ntitle\nASCII{polydata}POLYGONS 9 24\nOFFSETS vtktypeint64\n{ends}\n"
        f"CONNECTIVITY vtktypeint64\n{corners}\nCELL_DATA 8\nSCALARS a double 1\nLOOKUP_TABLE default\n"
        "1 2 3 4 5 6 7 8\n",
    )
    binary = points.astype(">f8").tobytes() + b"\nPOLYGONS 8 32\n"
    binary += np.insert(faces, 0, 3, axis=1).astype(">i4").tobytes()
    add("binary.vtk", b"# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\nPOINTS 6 double\n" + binary)
    for kind in ("ascii", "appended"):
        add(f"{kind}.vtp", vtp(points, faces, kind))
    add("buffers.glb", glb(points, faces))
    add("zipped.obj.gz", gzip.compress((folder / "written.obj").read_bytes()))
    lengths = {name: getattr(surface.metric, name).tolist() for name in ("faces", "edges", "lengths")}
    add("lengths.json", json.dumps(lengths))
    np.savez_compressed(folder / "lengths.npz", **lengths)
    add_file("lengths.npz")
    struts = list(enumerate(surface.metric.edges.tolist()))
    types = "".join(f"{k},{length},0.001\n" for k, length in enumerate(lengths["lengths"]))
    rows_of_types = "".join(f"{a},{b},{k}\n" for k, (a, b) in struts)
    add("types.csv", f"type,length (m),length error\n{types}\nfrom,to,type\n{rows_of_types}")
    commas = "".join(f"P{a};P{b};{lengths['lengths'][k]:.3f}\n" for k, (a, b) in struts).replace(".", ",")
    add("commas.csv", f"A survey\n\nFrom;To;Length\n{commas}".encode("utf-16"))
    for ending in (".json", ".fold"):
        write_net(folder / f"net{ending}", unfold(surface))
        add_file(f"net{ending}", read_net)
    pattern = json.loads((folder / "net.fold").read_text())
    pattern = {key: value for key, value in pattern.items() if not key.endswith(":corner")}
    add("angles.fold", json.dumps(pattern), read_net)
    theta, phi = np.pi * (np.arange(6) + 0.5) / 6, 2 * np.pi * np.arange(12) / 12
    grid = {"theta": theta, "phi": phi, "q_tt": np.ones((6, 12)), "q_tp": np.zeros((6, 12))}
    grid["q_pp"] = np.repeat(np.sin(theta)[:, None] ** 2, 12, axis=1)
    np.savez(folder / "grid.npz", **grid)
    add_file("grid.npz", read_grid_data)
    np.savez(folder / "points.npz", points=points, faces=faces)
    add_file("points.npz", read_horizon)
    add("horizon.vtk", found[[name for name, *_ in found].index("old.vtk")][1], read_horizon)
    rings = [
        [*((np.cos(p) * np.sin(t), np.sin(p) * np.sin(t), np.cos(t)) for p in phi - 11 * np.pi / 12)]
        for t in theta
    ]
    text = "\n\n".join("\n".join("{:.12f} {:.12f} {:.12f}".format(*x) for x in [*r, r[0]]) for r in rings)
    add("h.t0.ah1.gp", text + "\n", read_horizon)
    flat = {name: np.full((12, 12, 12), float(name in ("gxx", "gyy", "gzz"))) for name in SLICE}
    place = {"origin": np.zeros(3), "spacing": np.ones(3)}
    np.savez(folder / "slice.npz", **flat, **place)
    add_file("slice.npz", read_slice)
    try:
        import h5py
    except ImportError:
        return found
    for name, tables, read in (("grid.h5", grid, read_grid_data), ("slice.h5", flat | place, read_slice)):
        with h5py.File(folder / name, "w") as file:
            for key, table in tables.items():
                file[key] = table
        add_file(name, read)
    return found


SLICE = ("gxx", "gxy", "gxz", "gyy", "gyz", "gzz")


def vtp(points, faces, kind):
    """Polydata in XML, as text or appended raw bytes."""
    arrays = (points, faces.astype("i8"), 3 * np.arange(1, 9))
    blocks = [struct.pack("<I", array.nbytes) + array.tobytes() for array in arrays]
    offsets = np.cumsum([0, *map(len, blocks)])

    def element(k, name, type_name):
        start = f'<DataArray type="{type_name}" Name="{name}" NumberOfComponents="{3 if k == 0 else 1}"'
        if kind == "ascii":
            return f'{start} format="ascii">{" ".join(map(str, arrays[k].ravel()))}</DataArray>'
        return f'{start} format="appended" offset="{offsets[k]}"/>'

    text = (
        '<?xml version="1.0"?><VTKFile type="PolyData" version="1.0" byte_order="LittleEndian"><PolyData>'
        f'<Piece NumberOfPoints="6" NumberOfPolys="8"><Points>{element(0, "Points", "Float64")}</Points>'
        f"<Polys>{element(1, 'connectivity', 'Int64')}{element(2, 'offsets', 'Int64')}</Polys>"
        "</Piece></PolyData>"
    ).encode()
    if kind == "appended":
        text += b'<AppendedData encoding="raw">_' + b"".join(blocks) + b"</AppendedData>"
    return text + b"</VTKFile>"


def glb(points, faces):
    """A binary glTF file of one mesh."""
    parts = points.astype("<f4").tobytes(), faces.astype("<u2").tobytes()
    document = {
        "asset": {"version": "2.0"},
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0, "scale": [1, 2, 1]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 6, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 24, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 72},
            {"buffer": 0, "byteOffset": 72, "byteLength": 48},
        ],
        "buffers": [{"byteLength": 120}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary = b"".join(parts)
    body = (
        struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    )
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def damaged(data, rng):
    """The bytes with one to three random damages."""
    for _ in range(rng.choice((1, 1, 2, 3))):
        at, end = rng.randrange(len(data) + 1), rng.randrange(1, 40)
        kind = rng.randrange(8)
        if kind == 0:
            data = data[:at]
        elif kind == 1:
            data = data[:at] + data[at + end :]
        elif kind == 2:
            data = data[: at + end] + data[at:]
        elif kind == 3:
            data = data[:at] + rng.randbytes(rng.randrange(1, 9)) + data[at:]
        elif kind == 4:
            data = (
                data[:at]
                + struct.pack(rng.choice("<>") + "Q", rng.choice(WORDS))[: rng.choice((4, 8))]
                + data[at + 4 :]
            )
        elif kind == 5 and (found := [*NUMBER.finditer(data[at : at + 400])]):
            number = rng.choice(found)
            data = data[: at + number.start()] + rng.choice(NUMBERS) + data[at + number.end() :]
        else:
            data = data[:at] + bytes([rng.choice((rng.randrange(256), *b"09-. \n"))]) + data[at + 1 :]
        if not data:
            break
    return data


def outcome(read, path, limit):
    """What comes of a file: "read", "refused", or what is wrong with the answer."""
    signal.setitimer(signal.ITIMER_VIRTUAL, limit)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", MeshNote)
            read(path)
    except (FileError, InvalidMetric, InvalidParameter) as error:
        message = str(error).replace(str(path), "")
        if not message or not message.isprintable() or len(message) > LONGEST:
            return f"refusal: {message[:200]!r}"
        return "refused"
    except TooSlow:
        return "slow"
    except Exception as error:  # what is looked for
        trace = error.__traceback__
        while trace.tb_next and "isoembed" in trace.tb_next.tb_frame.f_code.co_filename:
            trace = trace.tb_next
        where = f"{Path(trace.tb_frame.f_code.co_filename).name}:{trace.tb_lineno}"
        return f"{type(error).__name__} at {where}: {str(error)[:120]!r}"
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    return "read"


def too_slow(*_):
    """End a reader."""
    raise TooSlow


def main():
    """Damage files, and count what comes of them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=1000, metavar="N", help="damages of each file")
    parser.add_argument("--first", type=int, default=0, metavar="SEED")
    parser.add_argument(
        "--limit", type=float, default=5.0, metavar="SECONDS", help="of the processor, a file"
    )
    parser.add_argument("--failures", type=Path, metavar="FOLDER", help="where files that fail are kept")
    parser.add_argument("--only", nargs="*", metavar="NAME", help="files")
    options = parser.parse_args()
    start = time.monotonic()
    signal.signal(signal.SIGVTALRM, too_slow)
    shared_memory = Path("/dev/shm")
    with tempfile.TemporaryDirectory(dir=shared_memory if shared_memory.is_dir() else None) as name:
        folder = Path(name)
        files = [row for row in sources(folder) if not options.only or row[0] in options.only]
        for source, content, read in files:  # compiles, and shows that each is right
            (folder / source).write_bytes(content)
            read(folder / source)
        used = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
        resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, resource.RLIM_INFINITY))
        total, wrong = 0, collections.Counter()
        for source, content, read in files:
            counts = collections.Counter()
            for seed in range(options.first, options.first + options.count):
                data = damaged(content, random.Random(f"{source} {seed}"))
                (folder / source).write_bytes(data)
                found = outcome(read, folder / source, options.limit)
                if found in ("read", "refused"):
                    counts[found] += 1
                    continue
                counts["wrong"] += 1
                kind = re.sub(
                    r"\d+", "0", found.split(": ")[0] if " at " not in found else found.split(": '")[0]
                )
                if not wrong[source, kind]:
                    print(f"  {source} {seed}: {found}", flush=True)
                    if options.failures:
                        options.failures.mkdir(parents=True, exist_ok=True)
                        (options.failures / f"{seed}-{source}").write_bytes(data)
                wrong[source, kind] += 1
            total += options.count
            numbers = (f"{counts[kind]:8} {kind}" for kind in ("read", "refused", "wrong"))
            print(f"{source:16}", *numbers, flush=True)
    seconds = time.monotonic() - start
    print(f"{total} files, {sum(wrong.values())} wrong, in {seconds:.0f} s")


if __name__ == "__main__":
    main()
