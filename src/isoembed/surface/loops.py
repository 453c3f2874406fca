# cython: boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False, infer_types=True
"""Compiled loops over faces, edges and vertices."""

from __future__ import annotations

import cython
import numpy as np
from cython.cimports.libc.math import sqrt

if cython.compiled:
    from cython.cimports.isoembed.space.trigonometry import triangle_area
else:
    from isoembed.space.trigonometry import triangle_area

Int = cython.typedef(cython.longlong)
ConstInt = cython.typedef(cython.const[cython.longlong])
Int32 = cython.typedef(cython.int)
ConstInt32 = cython.typedef(cython.const[cython.int])
Real = cython.typedef(cython.double)
ConstReal = cython.typedef(cython.const[cython.double])
Flag = cython.typedef(cython.uchar)
Single = cython.typedef(cython.float)

INF = cython.declare(cython.double, float("inf"))
TINY = cython.declare(cython.double, 2.2250738585072014e-308)  # the least normal number
SHUT = cython.declare(cython.double, 1e-9)  # as in `curvature`
MAX_AGGREGATE = cython.declare(cython.longlong, 48)  # vertices that move as one body, as in `two_level`


def face_normals(faces: ConstInt[:, :], vertices: ConstReal[:, ::1]):
    """Normals of the triangles with twice their areas as norms, (F, 3), by the right-hand rule."""
    normals: Real[:, ::1] = np.empty((faces.shape[0], 3))
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            normals[f, k] = (vertices[b, i] - vertices[a, i]) * (vertices[c, j] - vertices[a, j]) - (
                vertices[b, j] - vertices[a, j]
            ) * (vertices[c, i] - vertices[a, i])
    return np.asarray(normals)


def face_areas(faces: ConstInt[:, ::1], vertices: ConstReal[:, ::1]):
    """Areas of the triangles, (F,)."""
    normals: Real[:, ::1] = face_normals(faces, vertices)
    areas: Real[::1] = np.empty(faces.shape[0])
    for f in range(faces.shape[0]):
        a, b, c = normals[f, 0], normals[f, 1], normals[f, 2]
        areas[f] = sqrt(a * a + b * b + c * c) / 2
    return np.asarray(areas)


def vertex_normals(faces: ConstInt[:, ::1], vertices: ConstReal[:, ::1]):
    """Unit normals at the vertices, (V, 3): of the triangles, weighted by area; zero where they cancel."""
    x: Real
    y: Real
    z: Real
    largest: Real
    sums: Real[:, ::1] = np.zeros((vertices.shape[0], 3))
    normals: Real[:, ::1] = face_normals(faces, vertices)
    for f in range(faces.shape[0]):
        for corner in range(3):
            for k in range(3):
                sums[faces[f, corner], k] += normals[f, k]
    for v in range(vertices.shape[0]):
        x, y, z = sums[v, 0], sums[v, 1], sums[v, 2]
        largest = max(abs(x), abs(y), abs(z))
        if largest > 0:  # the squares of areas would underflow
            x, y, z = x / largest, y / largest, z / largest
            norm = sqrt(x * x + y * y + z * z)
            sums[v, 0], sums[v, 1], sums[v, 2] = x / norm, y / norm, z / norm
    return np.asarray(sums)


def curved_areas(face_lengths: ConstReal[:, ::1], k: Real):
    found: Real[::1] = np.empty(face_lengths.shape[0])
    for f in range(face_lengths.shape[0]):
        found[f] = triangle_area(face_lengths[f, 0], face_lengths[f, 1], face_lengths[f, 2], k)
    return np.asarray(found)


def boxes_of(faces: ConstInt[:, :], vertices: ConstReal[:, ::1]):
    """Signed volumes of the parallelepipeds over the triangles from the origin, (F,)."""
    normals: Real[:, ::1] = face_normals(faces, vertices)
    boxes: Real[::1] = np.empty(faces.shape[0])
    for f in range(faces.shape[0]):
        v = faces[f, 0]
        boxes[f] = (
            vertices[v, 0] * normals[f, 0] + vertices[v, 1] * normals[f, 1] + vertices[v, 2] * normals[f, 2]
        )
    return np.asarray(boxes)


def chosen_centers(
    indptr: ConstInt[::1], indices: ConstInt[::1], hops: ConstReal[::1], order: ConstInt[::1], radius: Real
):
    """Vertices, in order, farther than the radius from those before; and the cell of every vertex."""
    n = indptr.shape[0] - 1
    distance: Real[::1] = np.full(n, INF)
    cell: Int[::1] = np.full(n, -1, dtype=np.int64)
    waiting: Int[::1] = np.empty(n, dtype=np.int64)
    is_waiting: Flag[::1] = np.zeros(n, dtype=np.bool_)  # round and round
    chosen: Int[::1] = np.empty(n, dtype=np.int64)
    count: Int = 0
    head: Int
    size: Int
    for v in order:
        if distance[v] <= radius:
            continue
        chosen[count], distance[v], cell[v] = v, 0.0, count
        waiting[0] = v
        head = 0
        size = 1
        while size > 0:
            u = waiting[head]
            head, size = (head + 1) % n, size - 1
            is_waiting[u] = False
            for p in range(indptr[u], indptr[u + 1]):
                w, there = indices[p], distance[u] + hops[p]
                if there < distance[w] and there <= 2 * radius:
                    distance[w], cell[w] = there, count
                    if not is_waiting[w]:
                        waiting[(head + size) % n], is_waiting[w] = w, True
                        size += 1
        count += 1
    return np.array(chosen[:count]), np.asarray(cell)


def folds(
    edges: ConstInt[:, ::1],
    edge_halfedges: ConstInt[:, ::1],
    normals: ConstReal[:, ::1],
    vertices: ConstReal[:, ::1],
):
    """Sines and cosines of the dihedral angles, each (E,), times the norms of the normals."""
    sine: Real[::1] = np.empty(edges.shape[0])
    cosine: Real[::1] = np.empty(edges.shape[0])
    for e in range(edges.shape[0]):
        n, m = edge_halfedges[e, 0] // 3, edge_halfedges[e, 1] // 3
        n0, n1, n2 = normals[n, 0], normals[n, 1], normals[n, 2]
        m0, m1, m2 = normals[m, 0], normals[m, 1], normals[m, 2]
        a, b = edges[e, 0], edges[e, 1]
        x, y = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1]
        z = vertices[b, 2] - vertices[a, 2]
        length = max(sqrt(x * x + y * y + z * z), TINY)
        sine[e] = (
            (n1 * m2 - n2 * m1) * (x / length)
            + (n2 * m0 - n0 * m2) * (y / length)
            + (n0 * m1 - n1 * m0) * (z / length)
        )
        cosine[e] = n0 * m0 + n1 * m1 + n2 * m2
        if cosine[e] < 0 and abs(sine[e]) < SHUT:
            sine[e] = abs(sine[e])
    return np.asarray(sine), np.asarray(cosine)


def products_of(
    rows: ConstInt[::1],
    starts: ConstInt[::1],
    indptr: ConstInt[::1],
    indices: ConstInt[::1],
    weights: ConstReal[::1],
    values: ConstReal[:, ::1],
):
    products: Real[:, ::1] = np.empty((rows.shape[0], 3))
    at: Int = 0
    for cell in range(starts.shape[0] - 1):
        for k in range(starts[cell], starts[cell + 1]):
            x: Real = 0.0
            y: Real = 0.0
            z: Real = 0.0
            for p in range(indptr[cell], indptr[cell + 1]):
                vertex = indices[p]
                x += weights[at] * values[vertex, 0]
                y += weights[at] * values[vertex, 1]
                z += weights[at] * values[vertex, 2]
                at += 1
            row = rows[k]
            products[row, 0], products[row, 1], products[row, 2] = x, y, z
    return np.asarray(products)


def transposed_products(
    rows: ConstInt[::1],
    starts: ConstInt[::1],
    indptr: ConstInt[::1],
    indices: ConstInt[::1],
    weights: ConstReal[::1],
    forces: ConstReal[:, ::1],
):
    products: Real[:, ::1] = np.zeros((starts.shape[0] - 1, 3))
    largest: Int = 0
    for cell in range(starts.shape[0] - 1):
        largest = max(largest, indptr[cell + 1] - indptr[cell])
    sums: Real[:, ::1] = np.empty((3, largest))
    at: Int = 0
    for cell in range(starts.shape[0] - 1):
        begin, size = indptr[cell], indptr[cell + 1] - indptr[cell]
        sums[:, :size] = 0.0  # rows of numbers are added up at once
        for p in range(starts[cell], starts[cell + 1]):
            row = rows[p]
            for k in range(3):
                force = forces[row, k]
                for i in range(size):
                    sums[k, i] += force * weights[at + i]
            at += size
        for i in range(size):
            for k in range(3):
                products[indices[begin + i], k] += sums[k, i]
    return np.asarray(products)


def projected(
    points: ConstReal[:, ::1],
    normals: ConstReal[:, ::1],
    units: ConstReal[::1],
    targets: ConstReal[:, ::1],
    indptr: ConstInt[::1],
    indices: ConstInt[::1],
):
    """Targets in the tangent planes at points, in their units, (nnz, 2).

    Not in polar charts: these are no smooth coordinates of a surface that is curved otherwise than a sphere.
    """
    x: Real
    y: Real
    k: Int
    charts: Real[:, ::1] = np.empty((indices.shape[0], 2))
    first: Real[::1] = np.empty(3)
    second: Real[::1] = np.empty(3)
    for row in range(points.shape[0]):
        unit = units[row]
        k = 0
        for c in range(1, 3):
            if abs(normals[row, c]) < abs(normals[row, k]):
                k = c
        i, j = (k + 1) % 3, (k + 2) % 3
        size = sqrt(normals[row, i] * normals[row, i] + normals[row, j] * normals[row, j])
        first[k], first[i], first[j] = 0.0, -normals[row, j] / size, normals[row, i] / size
        for c in range(3):
            a, b = (c + 1) % 3, (c + 2) % 3
            second[c] = normals[row, a] * first[b] - normals[row, b] * first[a]
        for at in range(indptr[row], indptr[row + 1]):
            there = indices[at]
            x = y = 0.0
            for c in range(3):
                x += first[c] * (targets[there, c] - points[row, c])
                y += second[c] * (targets[there, c] - points[row, c])
            charts[at, 0], charts[at, 1] = x / unit, y / unit
    return np.asarray(charts)


def add_cell_products(
    starts: ConstInt[::1],
    stencil_indptr: ConstInt[::1],
    stencil_indices: ConstInt[::1],
    differences: ConstReal[::1],
    rows: ConstReal[:, ::1],
    indptr: ConstInt[::1],
    indices: ConstInt[::1],
    values: Real[::1],
):
    """Add the products of the rows of each cell to the zeros of a symmetric matrix in blocks of 3 x 3.

    They are added up below the diagonal, then copied above it.
    """
    n = indptr.shape[0] - 1
    diagonal: Int[::1] = np.empty(n, dtype=np.int64)
    for column in range(n):
        p: Int = indptr[column]
        while indices[p] < column:
            p += 1
        diagonal[column] = p
    at: Int = 0  # in the differences
    for cell in range(starts.shape[0] - 1):
        first, last = starts[cell], starts[cell + 1]
        begin = stencil_indptr[cell]
        size = stencil_indptr[cell + 1] - begin
        if first == last:
            continue
        dense = np.empty((last - first, 3 * size), dtype=np.float32)
        J: Single[:, ::1] = dense
        for edge in range(first, last):
            for j in range(size):
                for k in range(3):
                    J[edge - first, 3 * j + k] = differences[at] * rows[edge, k]
                at += 1
        products: Single[:, ::1] = np.dot(dense.T, dense)
        for j in range(size):
            column = stencil_indices[begin + j]
            start = indptr[column]
            p = diagonal[column]
            width = 3 * (indptr[column + 1] - start)
            for i in range(j, size):
                row = stencil_indices[begin + i]
                while indices[p] < row:
                    p += 1
                place = 9 * start + 3 * (p - start)
                for b in range(3):
                    for a in range(3):
                        values[place + b * width + a] += products[3 * j + b, 3 * i + a]
    above: Int[::1] = np.array(indptr[:n])  # the next block above the diagonal, by column
    for column in range(n):
        start, width = indptr[column], 3 * (indptr[column + 1] - indptr[column])
        for p in range(diagonal[column] + 1, indptr[column + 1]):
            row = indices[p]
            first, mirrored = indptr[row], 3 * (indptr[row + 1] - indptr[row])
            place = 9 * start + 3 * (p - start)
            image = 9 * first + 3 * (above[row] - first)
            above[row] += 1
            for b in range(3):
                for a in range(3):
                    values[image + a * mirrored + b] = values[place + b * width + a]


def couplings(ends: ConstInt32[:, ::1], degrees: ConstInt[::1], entries: Int):
    v: Int
    f: Int
    g: Int
    count, n = ends.shape[0], degrees.shape[0]
    start: Int[::1] = np.zeros(n + 1, dtype=np.int64)
    for v in range(n):
        start[v + 1] = start[v] + degrees[v]
    at: Int32[::1] = np.empty(2 * count, dtype=np.int32)
    met: Int[::1] = np.array(start[:n])
    for e in range(count):  # the edges at each vertex, ascending
        for side in range(2):
            v = ends[e, side]
            at[met[v]] = e
            met[v] += 1
    indptr: Int32[::1] = np.zeros(count + 1, dtype=np.int32)
    indices: Int32[::1] = np.empty(entries, dtype=np.int32)
    p: Int = 0
    i: Int
    j: Int
    for e in range(count):
        a, b = ends[e, 0], ends[e, 1]
        i, j = start[a], start[b]
        while i < start[a + 1] or j < start[b + 1]:
            f = at[i] if i < start[a + 1] else count
            g = at[j] if j < start[b + 1] else count
            i += f <= g
            j += g <= f
            indices[p] = min(f, g)
            p += 1
        indptr[e + 1] = p
    return np.asarray(indptr), np.asarray(indices)


def edge_rows(ends: ConstInt32[:, ::1], positions: ConstReal[:, ::1], lengths: ConstReal[::1]):
    rows: Real[:, ::1] = np.empty((ends.shape[0], 3))
    for e in range(ends.shape[0]):
        a, b = ends[e, 0], ends[e, 1]
        for k in range(3):
            rows[e, k] = (positions[a, k] - positions[b, k]) / lengths[e]
    return np.asarray(rows)


def length_rates(ends: ConstInt32[:, ::1], rows: ConstReal[:, ::1], motion: ConstReal[:, :]):
    rates: Real[::1] = np.empty(ends.shape[0])
    for e in range(ends.shape[0]):
        a, b = ends[e, 0], ends[e, 1]
        rates[e] = (
            rows[e, 0] * (motion[a, 0] - motion[b, 0])
            + rows[e, 1] * (motion[a, 1] - motion[b, 1])
            + rows[e, 2] * (motion[a, 2] - motion[b, 2])
        )
    return np.asarray(rates)


def vertex_forces(ends: ConstInt32[:, ::1], rows: ConstReal[:, ::1], tensions: ConstReal[::1], vertices: Int):
    forces: Real[:, ::1] = np.zeros((vertices, 3))
    for e in range(ends.shape[0]):
        a, b = ends[e, 0], ends[e, 1]
        x, y, z = rows[e, 0] * tensions[e], rows[e, 1] * tensions[e], rows[e, 2] * tensions[e]
        forces[a, 0] += x  # a loop would read these back ten times as slowly
        forces[a, 1] += y
        forces[a, 2] += z
        forces[b, 0] -= x
        forces[b, 1] -= y
        forces[b, 2] -= z
    return np.asarray(forces)


def gram_values(
    ends: ConstInt32[:, ::1],
    rows: ConstReal[:, ::1],
    indptr: ConstInt32[::1],
    indices: ConstInt32[::1],
    shift: Real,
):
    values: Real[::1] = np.empty(indices.shape[0])
    for e in range(ends.shape[0]):
        a, b = ends[e, 0], ends[e, 1]
        x, y, z = rows[e, 0], rows[e, 1], rows[e, 2]
        for p in range(indptr[e], indptr[e + 1]):
            f = indices[p]
            product = x * rows[f, 0] + y * rows[f, 1] + z * rows[f, 2]
            if f == e:
                values[p] = 2.0 * product + shift
            elif ends[f, 0] == a or ends[f, 1] == b:
                values[p] = product
            else:  # one ends where the other begins
                values[p] = -product
    return np.asarray(values)


def residuals_of(
    indptr: ConstInt32[::1],
    indices: ConstInt32[::1],
    weights: ConstReal[::1],
    own: ConstReal[::1],
    vectors: ConstReal[:, ::1],
):
    x: Real
    y: Real
    z: Real
    residuals: Real[:, ::1] = np.empty((vectors.shape[0], 3))
    for v in range(own.shape[0]):
        x, y, z = own[v] * vectors[v, 0], own[v] * vectors[v, 1], own[v] * vectors[v, 2]
        for p in range(indptr[v], indptr[v + 1]):
            w = indices[p]
            x -= weights[p] * vectors[w, 0]
            y -= weights[p] * vectors[w, 1]
            z -= weights[p] * vectors[w, 2]
        residuals[v, 0], residuals[v, 1], residuals[v, 2] = x, y, z
    return np.asarray(residuals)


def transposed_residuals_of(
    indptr: ConstInt32[::1],
    indices: ConstInt32[::1],
    weights: ConstReal[::1],
    own: ConstReal[::1],
    vectors: ConstReal[:, ::1],
):
    products: Real[:, ::1] = np.zeros((vectors.shape[0], 3))
    for v in range(own.shape[0]):
        x, y, z = vectors[v, 0], vectors[v, 1], vectors[v, 2]
        products[v, 0] += own[v] * x
        products[v, 1] += own[v] * y
        products[v, 2] += own[v] * z
        for p in range(indptr[v], indptr[v + 1]):
            w = indices[p]
            products[w, 0] -= weights[p] * x
            products[w, 1] -= weights[p] * y
            products[w, 2] -= weights[p] * z
    return np.asarray(products)


def polar_charts(begin: Int, indptr: ConstInt[::1], indices: ConstInt32[::1], surface: object):
    """Directions of neighbors in the tangent planes of vertices, times distances in their units, (nnz, 2)."""
    vertices: ConstReal[:, ::1] = surface.vertices
    normals: ConstReal[:, ::1] = surface.normals
    units: ConstReal[::1] = surface.units
    k: Int
    charts: Real[:, ::1] = np.zeros((indices.shape[0], 2))
    first: Real[::1] = np.empty(3)
    second: Real[::1] = np.empty(3)  # perpendicular to each other and to the normal, of equal size
    for row in range(indptr.shape[0] - 1):
        v = begin + row
        unit = units[v]
        k = 0
        for c in range(1, 3):
            if abs(normals[v, c]) < abs(normals[v, k]):
                k = c
        i, j = (k + 1) % 3, (k + 2) % 3
        first[k], first[i], first[j] = 0.0, -normals[v, j], normals[v, i]
        for c in range(3):
            a, b = (c + 1) % 3, (c + 2) % 3
            second[c] = normals[v, a] * first[b] - normals[v, b] * first[a]
        for at in range(indptr[row], indptr[row + 1]):
            w = indices[at]
            dx, dy = vertices[w, 0] - vertices[v, 0], vertices[w, 1] - vertices[v, 1]
            dz = vertices[w, 2] - vertices[v, 2]
            x = first[0] * dx + first[1] * dy + first[2] * dz
            y = second[0] * dx + second[1] * dy + second[2] * dz
            in_plane = x * x + y * y
            if in_plane > 0.0:
                stretch = sqrt((dx * dx + dy * dy + dz * dz) / in_plane) / unit
                charts[at, 0], charts[at, 1] = stretch * x, stretch * y
    return np.asarray(charts)


def take_away_rigid(motion: Real[:, ::1], arms: ConstReal[:, ::1], turning: ConstReal[:, ::1]):
    """Take from a motion, (V, 3), the translation and the rotation in it.

    ``arms`` reach from the center; ``turning`` is the inverse of their moments of inertia.
    """
    shift: Real[::1] = np.zeros(3)
    momentum: Real[::1] = np.zeros(3)
    wrench: Real[::1] = np.empty(6)
    for v in range(motion.shape[0]):
        _set_wrench(arms, v, motion[v, 0], motion[v, 1], motion[v, 2], wrench)
        for k in range(3):
            shift[k] += wrench[k]
            momentum[k] += wrench[3 + k]
    for k in range(3):
        shift[k] /= motion.shape[0]
    x: Real = turning[0, 0] * momentum[0] + turning[0, 1] * momentum[1] + turning[0, 2] * momentum[2]
    y: Real = turning[1, 0] * momentum[0] + turning[1, 1] * momentum[1] + turning[1, 2] * momentum[2]
    z: Real = turning[2, 0] * momentum[0] + turning[2, 1] * momentum[1] + turning[2, 2] * momentum[2]
    for v in range(motion.shape[0]):
        motion[v, 0] -= shift[0] + y * arms[v, 2] - z * arms[v, 1]
        motion[v, 1] -= shift[1] + z * arms[v, 0] - x * arms[v, 2]
        motion[v, 2] -= shift[2] + x * arms[v, 1] - y * arms[v, 0]


def aggregates(cells: ConstInt[::1]):
    """Number the cells of a tree, as in `Dissection.cells`, that are the largest with few vertices."""
    n = cells.shape[0]
    order: Int[::1] = np.argsort(cells)
    of_vertex: Int32[::1] = np.empty(n, dtype=np.int32)
    count: Int = 0
    start: Int
    end: Int
    bit: Int
    depth = int(np.max(cells)).bit_length()
    waiting = [(0, n, depth)]
    while waiting:
        start, end, bit = waiting.pop()
        if end - start <= MAX_AGGREGATE or bit == 0:
            for p in range(start, end):
                of_vertex[order[p]] = count
            count += 1
            continue
        middle: Int = start
        while middle < end and (cells[order[middle]] >> (bit - 1)) & 1 == 0:
            middle += 1
        if middle > start:
            waiting.append((start, middle, bit - 1))
        if end > middle:
            waiting.append((middle, end, bit - 1))
    return np.asarray(of_vertex)


def diagonal_blocks(ends: ConstInt32[:, ::1], rows: ConstReal[:, ::1], vertices: Int):
    blocks: Real[:, :, ::1] = np.zeros((vertices, 3, 3))
    for e in range(ends.shape[0]):
        for side in range(2):
            v = ends[e, side]
            for i in range(3):
                for j in range(3):
                    blocks[v, i, j] += rows[e, i] * rows[e, j]
    return np.asarray(blocks)


def times_blocks(blocks: ConstReal[:, :, ::1], vectors: ConstReal[:, ::1]):
    products: Real[:, ::1] = np.zeros((vectors.shape[0], 3))
    for v in range(vectors.shape[0]):
        for i in range(3):
            for j in range(3):
                products[v, i] += blocks[v, i, j] * vectors[v, j]
    return np.asarray(products)


@cython.cfunc
@cython.exceptval(check=False)
def _set_wrench(arms: ConstReal[:, ::1], v: Int, x: Real, y: Real, z: Real, wrench: Real[::1]) -> cython.void:
    """Set a force and its moment about the center of the body."""
    wrench[0], wrench[1], wrench[2] = x, y, z
    wrench[3] = arms[v, 1] * z - arms[v, 2] * y
    wrench[4] = arms[v, 2] * x - arms[v, 0] * z
    wrench[5] = arms[v, 0] * y - arms[v, 1] * x


def wrenches_of(of_vertex: ConstInt32[::1], arms: ConstReal[:, ::1], count: Int, forces: ConstReal[:, ::1]):
    wrenches: Real[:, ::1] = np.zeros((count, 6))
    wrench: Real[::1] = np.empty(6)
    for v in range(forces.shape[0]):
        _set_wrench(arms, v, forces[v, 0], forces[v, 1], forces[v, 2], wrench)
        for k in range(6):
            wrenches[of_vertex[v], k] += wrench[k]
    return np.asarray(wrenches)


def motions_of(of_vertex: ConstInt32[::1], arms: ConstReal[:, ::1], moved: ConstReal[:, ::1]):
    motions: Real[:, ::1] = np.empty((of_vertex.shape[0], 3))
    for v in range(of_vertex.shape[0]):
        body = of_vertex[v]
        tx, ty, tz = moved[body, 0], moved[body, 1], moved[body, 2]
        wx, wy, wz = moved[body, 3], moved[body, 4], moved[body, 5]
        x, y, z = arms[v, 0], arms[v, 1], arms[v, 2]
        motions[v, 0] = tx + wy * z - wz * y
        motions[v, 1] = ty + wz * x - wx * z
        motions[v, 2] = tz + wx * y - wy * x
    return np.asarray(motions)


def coarse_blocks(
    ends: ConstInt32[:, ::1],
    rows: ConstReal[:, ::1],
    of_vertex: ConstInt32[::1],
    arms: ConstReal[:, ::1],
    indptr: ConstInt32[::1],
    indices: ConstInt32[::1],
    damping: Real,
):
    """``P^T (J^T J + damping I) P``, (nnz, 6, 6), P being the motions of the bodies."""
    blocks: Real[:, :, ::1] = np.zeros((indices.shape[0], 6, 6))
    bodies: Int[::1] = np.empty(2, dtype=np.int64)
    first: Real[::1] = np.empty(6)
    second: Real[::1] = np.empty(6)
    for e in range(ends.shape[0]):
        v, w = ends[e, 0], ends[e, 1]
        bodies[0], bodies[1] = of_vertex[v], of_vertex[w]
        _set_wrench(arms, v, rows[e, 0], rows[e, 1], rows[e, 2], first)
        _set_wrench(arms, w, -rows[e, 0], -rows[e, 1], -rows[e, 2], second)
        if bodies[0] == bodies[1]:
            continue
        _add_outer(blocks, _place(indptr, indices, bodies[0], bodies[0]), 1.0, first, first)
        _add_outer(blocks, _place(indptr, indices, bodies[0], bodies[1]), 1.0, first, second)
        _add_outer(blocks, _place(indptr, indices, bodies[1], bodies[0]), 1.0, second, first)
        _add_outer(blocks, _place(indptr, indices, bodies[1], bodies[1]), 1.0, second, second)
    if damping > 0:
        for u in range(of_vertex.shape[0]):
            at = _place(indptr, indices, of_vertex[u], of_vertex[u])
            for k in range(3):
                _set_wrench(arms, u, k == 0, k == 1, k == 2, first)
                _add_outer(blocks, at, damping, first, first)
    return np.asarray(blocks)


@cython.cfunc
@cython.exceptval(check=False)
def _place(indptr: ConstInt32[::1], indices: ConstInt32[::1], row: Int, column: Int) -> Int:
    """Where an entry is: that of the sorted columns of a row."""
    low: Int = indptr[row]
    high: Int = indptr[row + 1]
    while low < high:
        middle = (low + high) // 2
        if indices[middle] < column:
            low = middle + 1
        else:
            high = middle
    return low


@cython.cfunc
@cython.exceptval(check=False)
def _add_outer(blocks: Real[:, :, ::1], at: Int, factor: Real, x: Real[::1], y: Real[::1]) -> cython.void:
    """Add a multiple of the products of two vectors to a block."""
    for a in range(6):
        for b in range(6):
            blocks[at, a, b] += factor * x[a] * y[b]
