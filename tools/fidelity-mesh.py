#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Make meshes of a NRRD volume as 3D Slicer does, for tools/fidelity: discrete flying edges and windowed
sinc smoothing, both on the grid of the voxels, and only then a transform to RAS+ millimetres.
Usage: fidelity-mesh.py IN.nrrd OUT.ply ITERATIONS PASS_BAND   the mesh of label 1"""
import re
import sys

# Single modules, because vtkmodules.all also loads readers that need MPI.
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkCommonTransforms import vtkTransform
from vtkmodules.vtkFiltersCore import vtkWindowedSincPolyDataFilter
from vtkmodules.vtkFiltersGeneral import vtkDiscreteFlyingEdges3D, vtkTransformPolyDataFilter
from vtkmodules.vtkImagingCore import vtkImageConstantPad
from vtkmodules.vtkIOImage import vtkNrrdReader
from vtkmodules.vtkIOPLY import vtkPLYWriter


def to_ras(path):
    """The transform from voxel indices to RAS+ mm that the header of a NRRD file states."""
    with open(path, 'rb') as file:
        head = file.read(1 << 16).split(b'\n\n', 1)[0].decode('latin-1')

    def vectors(key):
        line = re.search(r'^%s:(.*)$' % key, head, re.M).group(1)
        return [[float(v) for v in vector.split(',')] for vector in re.findall(r'\(([^)]*)\)', line)]

    space = re.search(r'^space:\s*(\S+)', head, re.M).group(1)
    signs = [-1, -1, 1] if space in ('left-posterior-superior', 'LPS') else [1, 1, 1]
    matrix = vtkMatrix4x4()
    for column, vector in enumerate(vectors('space directions') + vectors('space origin')):
        for row in range(3):
            matrix.SetElement(row, column, signs[row] * vector[row])
    transform = vtkTransform()
    transform.SetMatrix(matrix)
    return transform


def write_mesh(image, iterations, band, transform, target):
    """Write the mesh of label 1 of an image to the PLY file target."""
    edges = vtkDiscreteFlyingEdges3D()
    edges.SetInputData(image)
    edges.SetValue(0, 1)
    edges.ComputeScalarsOff()
    smooth = vtkWindowedSincPolyDataFilter()
    smooth.SetInputConnection(edges.GetOutputPort())
    smooth.SetNumberOfIterations(iterations)
    smooth.SetPassBand(band)
    smooth.BoundarySmoothingOff()
    smooth.FeatureEdgeSmoothingOff()
    smooth.NonManifoldSmoothingOn()
    smooth.NormalizeCoordinatesOn()
    placed = vtkTransformPolyDataFilter()
    placed.SetTransform(transform)
    placed.SetInputConnection((smooth if iterations else edges).GetOutputPort())
    writer = vtkPLYWriter()
    writer.SetInputConnection(placed.GetOutputPort())
    writer.SetFileName(target)
    writer.Write()


def padded(source):
    """The image of a NRRD file on the grid of its voxels, with a frame of background around it, so that
    tissues at the border of the volume get closed meshes."""
    reader = vtkNrrdReader()
    reader.SetFileName(source)
    reader.Update()
    image = vtkImageData()
    image.ShallowCopy(reader.GetOutput())
    image.SetOrigin(0, 0, 0)
    image.SetSpacing(1, 1, 1)
    image.SetDirectionMatrix(1, 0, 0, 0, 1, 0, 0, 0, 1)
    frame = vtkImageConstantPad()
    frame.SetInputData(image)
    extent = image.GetExtent()
    frame.SetOutputWholeExtent([v + (1 if i % 2 else -1) for i, v in enumerate(extent)])
    frame.SetConstant(0)
    frame.Update()
    return frame.GetOutput()


def main():
    source, target, iterations, band = sys.argv[1], sys.argv[2], int(sys.argv[3]), float(sys.argv[4])
    write_mesh(padded(source), iterations, band, to_ras(source), target)


main()
