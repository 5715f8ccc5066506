# SPDX-License-Identifier: BSD-3-Clause
# Meshes are read back by other programs: closed around every tissue, of its volume, name and colour, with the
# vertices of both tissues the same wherever two touch. VTK reads GLB and STL, assimp 3MF and GLB; PLY is read by
# the script below itself, as VTK does not give the labels of its faces.
# A block of a tissue with one voxel of another in its corner, which larger voxels swallow.
{
    printf 'NRRD0004\ntype: uint8\ndimension: 3\nspace: RAS\nsizes: 14 14 14\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: ascii\n\n'
    awk 'BEGIN {for (i = 0; i < 2744; i++) {x = i % 14; y = int(i / 14) % 14; z = int(i / 196)
        print (x == 12 && y == 12 && z == 12 ? 2 : (x > 1 && x < 12 && y > 1 && y < 12 && z > 1 && z < 12))}}'
} >corner.nrrd
expect 0 'warning: "label 2" \(label 2, 0 voxels\) has no surface, .*; it is left out' \
    "$SEGCAST" convert corner.nrrd -o corner.ply --set volume.resample=3
expect 65 '"label 2" .* has no surface' "$SEGCAST" convert corner.nrrd -o two.ply --tissue 2 --set volume.resample=3
one_error
expect 73 'corner.ply: exists' "$SEGCAST" convert corner.nrrd -o corner.ply
expect 0 '' "$SEGCAST" convert corner.nrrd -o corner.ply --overwrite
grep -aq 'comment label 2 label 2' corner.ply || fail 'the voxel is lost'
find_python 'vtkmodules.vtkIOGeometry, numpy' 'python3-vtk9 python3-numpy'
command -v assimp >/dev/null || skip 'there is no assimp (Debian: assimp-utils)'
heart=phantom:128x96x128
"$SEGCAST" info $heart --json -q >info.json
for ending in ply glb 3mf; do
    "$SEGCAST" convert $heart -o "heart.$ending" -q >/dev/null
    "$SEGCAST" convert $heart -o "again.$ending" --threads 3 -q >/dev/null
    cmp "heart.$ending" "again.$ending" || fail "the bytes of .$ending depend on the number of threads"
done
"$SEGCAST" convert $heart -o aorta.stl --tissue aorta -q >/dev/null
"$SEGCAST" convert $heart -o few.ply --simplify 0.1 -q >/dev/null || skip 'this segcast has no meshoptimizer (Debian: libmeshoptimizer-dev)'
"$SEGCAST" convert $heart -o few.glb --simplify 0.1 -q --threads 3 >/dev/null
expect 64 '--simplify is "0", expected a length in mm' "$SEGCAST" convert $heart -o none.ply --simplify 0; one_error
expect 64 '--simplify is for a mesh, but heart.segc is none' "$SEGCAST" convert $heart -o heart.segc --simplify 0.1; one_error
expect 71 'the mesh of .* triangles takes about' "$SEGCAST" convert $heart -o none.ply --simplify 0.1 --max-memory 40M; one_error
# A file may be one that assimp has no name for; -tri keeps triangles as they are.
for ending in glb 3mf; do
    assimp export "heart.$ending" "assimp-$ending.obj" -tri >/dev/null || fail "assimp cannot read .$ending"
done

cat >compare.py <<'PYTHON'
import json, struct, sys
import numpy as np
from vtkmodules.vtkCommonCore import reference, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData, vtkStaticCellLocator
from vtkmodules.vtkFiltersCore import vtkCleanPolyData, vtkFeatureEdges, vtkMassProperties, vtkTriangleFilter
from vtkmodules.vtkIOGeometry import vtkGLTFReader, vtkSTLReader
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy

tissues = {t['value']: t for t in json.load(open('info.json'))['labels'] if t['value']}
names = {t['name']: t for t in tissues.values()}

def volume(points, triangles):
    p = points[triangles] - points.mean(0)
    return np.einsum('ij,ij->i', p[:, 0], np.cross(p[:, 1], p[:, 2])).sum() / 6

def is_closed(triangles): # as many triangles on one side of every edge as on the other
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    there = np.sort(edges[:, 0] << 32 | edges[:, 1])
    back = np.sort(edges[:, 1] << 32 | edges[:, 0])
    return (there == back).all()

def read_ply(path):
    data = open(path, 'rb').read()
    end = data.index(b'end_header\n') + 11
    header = data[:end].decode().splitlines()
    counts = [int(l.split()[2]) for l in header if l.startswith('element')]
    points = np.frombuffer(data, '<f4', 3 * counts[0], end).reshape(-1, 3).astype(float)
    faces = np.frombuffer(data, np.dtype([('n', 'u1'), ('v', '<i4', 3), ('rgb', 'u1', 3), ('label', '<i4')]), counts[1],
                          end + 12 * counts[0])
    assert end + 12 * counts[0] + 20 * counts[1] == len(data) and (faces['n'] == 3).all()
    told = dict(l.split(' ', 3)[2:] for l in header if l.startswith('comment label'))
    assert told == {str(v): t['name'] for v, t in tissues.items()}, told
    return points, faces

def read_vtk_glb(path): # tissue by tissue: assimp's files tell that their order is that of the names
    reader = vtkGLTFReader()
    reader.SetFileName(path)
    reader.Update()
    iterator = reader.GetOutput().NewIterator()
    iterator.InitTraversal()
    while not iterator.IsDoneWithTraversal():
        yield iterator.GetCurrentDataObject()
        iterator.GoToNextItem()

def check_vtk(data, what): # of the triangles as VTK has them
    whole = vtkTriangleFilter()
    whole.SetInputData(data)
    edges = vtkFeatureEdges()
    edges.SetInputConnection(whole.GetOutputPort())
    edges.BoundaryEdgesOn(), edges.FeatureEdgesOff(), edges.NonManifoldEdgesOff(), edges.ManifoldEdgesOff()
    edges.Update()
    assert edges.GetOutput().GetNumberOfCells() == 0, '%s: open edges in VTK' % what
    mass = vtkMassProperties()
    mass.SetInputConnection(whole.GetOutputPort())
    return mass.GetVolume()

def read_obj(path):
    points, groups, name = [], {}, None
    for line in open(path):
        words = line.split()
        if line.startswith('v '):
            points.append([float(w) for w in words[1:4]])
        elif line.startswith('usemtl '):
            name = line.split(' ', 1)[1].strip()
        elif line.startswith('f '):
            groups.setdefault(name, []).append([int(w.split('/')[0]) - 1 for w in words[1:4]])
    return np.array(points), {n: np.array(g) for n, g in groups.items()}

def distance(of, points, triangles): # of some of these points from a surface
    surface, at, cells = vtkPolyData(), vtkPoints(), vtkCellArray()
    at.SetData(numpy_to_vtk(points.copy()))
    surface.SetPoints(at)
    cells.SetCells(len(triangles), numpy_to_vtkIdTypeArray(np.insert(triangles, 0, 3, axis=1).astype(np.int64).ravel(), deep=1))
    surface.SetPolys(cells)
    locator = vtkStaticCellLocator()
    locator.SetDataSet(surface)
    locator.BuildLocator()
    nearest, cell, part, square = [0, 0, 0], reference(0), reference(0), reference(0.0)
    found = []
    for point in of[::max(1, len(of) // 500)]:
        locator.FindClosestPoint(point, nearest, cell, part, square)
        found.append(float(square) ** 0.5)
    return np.array(found)

def near(a, b, share, what):
    assert abs(a / b - 1) < share, '%s: %g, expected %g within %g %%' % (what, a, b, 100 * share)

points, faces = read_ply('heart.ply')
assert len(np.unique(points, axis=0)) == len(points), 'two vertices are at one place'
volumes = {}
for value, tissue in tissues.items():
    of_tissue = faces[faces['label'] == value]
    assert is_closed(of_tissue['v']), '%s is not closed' % tissue['name']
    assert (of_tissue['rgb'] == tissue['color']).all(), '%s has another colour' % tissue['name']
    volumes[value] = volume(points, of_tissue['v'])
    if tissue['thickness_mm'] > 9: # thinner ones are drawn with another volume than their voxels have
        near(volumes[value], tissue['volume_mm3'], 0.005, tissue['name'] + ' beside its voxels')

# Simplified: fewer triangles, still closed, of the same volume, near the surface, and with the vertices of tissues that touch shared.
few_points, few = read_ply('few.ply')
assert len(few) < len(faces) / 2, 'simplified: %d of %d triangles' % (len(few), len(faces))
assert {tuple(p) for p in few_points.tolist()} <= {tuple(p) for p in points.tolist()}, 'simplified: there are new vertices'
assert len(np.unique(few['v'])) == len(few_points) == len(np.unique(few_points, axis=0))
for value, tissue in tissues.items():
    of_tissue, whole = few[few['label'] == value]['v'], faces[faces['label'] == value]['v']
    assert is_closed(of_tissue), '%s, simplified, is not closed' % tissue['name']
    near(volume(few_points, of_tissue), volumes[value], 0.005, tissue['name'] + ', simplified')
    distances = distance(points[np.unique(whole)], few_points, of_tissue)
    assert distances.mean() < 0.05 and np.percentile(distances, 99) < 0.15, (tissue["name"], distances.mean(), distances.max())
for part, (value, tissue) in zip(read_vtk_glb('few.glb'), sorted(tissues.items())):
    near(check_vtk(part, tissue['name'] + ', simplified') * 1e9, volumes[value], 0.005, tissue['name'] + ', simplified, in VTK')

parts = list(read_vtk_glb('heart.glb'))
assert len(parts) == len(tissues)
glb_points = set()
for part, (value, tissue) in zip(parts, sorted(tissues.items())):
    near(check_vtk(part, tissue['name']) * 1e9, volumes[value], 0.0005, tissue['name'] + ' in VTK')
    here = vtk_to_numpy(part.GetPoints().GetData())
    assert len({tuple(p) for p in here.tolist()}) == len(here)
    glb_points |= {tuple(p) for p in here.tolist()}
    normals = vtk_to_numpy(part.GetPointData().GetNormals())
    assert abs(np.linalg.norm(normals, axis=1) - 1).max() < 1e-4
assert len(glb_points) == len(points), 'tissues that touch have other vertices each: %d, %d' % (len(glb_points), len(points))
# y is up: superior; z is towards the viewer: anterior; and what is left there is the patient's right, at -x.
turned = np.array(sorted(glb_points)) * 1000
assert abs(turned.min(0) - np.array([-points[:, 0].max(), points[:, 2].min(), points[:, 1].min()])).max() < 1e-3

reader = vtkSTLReader()
reader.SetFileName('aorta.stl')
clean = vtkCleanPolyData()
clean.SetInputConnection(reader.GetOutputPort())
clean.Update()
near(check_vtk(clean.GetOutput(), 'aorta.stl'), volumes[names['aorta']['value']], 0.002, 'aorta.stl')

for ending, scale in ('3mf', 1), ('glb', 1e9):
    obj_points, groups = read_obj('assimp-%s.obj' % ending)
    assert len(obj_points) == len(points), '.%s has %d vertices, .ply %d' % (ending, len(obj_points), len(points))
    groups = {n.removeprefix('id1_'): g for n, g in groups.items()}
    assert set(groups) == set(names), set(groups) ^ set(names)
    for name, triangles in groups.items():
        assert is_closed(triangles), '%s is not closed in assimp, read from .%s' % (name, ending)
        near(volume(obj_points, triangles) * scale, volumes[names[name]['value']], 0.0005, '%s from .%s' % (name, ending))

# glTF's own rules: lengths, alignment, the box of positions.
data = open('heart.glb', 'rb').read()
magic, version, length, json_length, kind = struct.unpack('<IIIII', data[:20])
assert (magic, version, length, kind) == (0x46546c67, 2, len(data), 0x4e4f534a) and json_length % 4 == 0
gltf = json.loads(data[20:20 + json_length])
assert [m['name'] for m in gltf['materials']] == [t['name'] for _, t in sorted(tissues.items())]
assert sum(v['byteLength'] for v in gltf['bufferViews']) == gltf['buffers'][0]['byteLength'] == len(data) - 28 - json_length
PYTHON
"$python" compare.py || fail 'a mesh is not read back as it should be'
