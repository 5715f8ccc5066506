#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Make a mesh of label 1 of a NRRD volume as 3D Slicer does, by discrete flying edges and windowed sinc
smoothing, for tools/fidelity. Usage: fidelity-mesh.py IN.nrrd OUT.ply ITERATIONS PASS_BAND"""
import sys

# Single modules, because vtkmodules.all also loads readers that need MPI.
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkWindowedSincPolyDataFilter
from vtkmodules.vtkFiltersGeneral import vtkDiscreteFlyingEdges3D
from vtkmodules.vtkIOImage import vtkNrrdReader
from vtkmodules.vtkIOPLY import vtkPLYWriter

source, target, iterations, band = sys.argv[1:5]
reader = vtkNrrdReader()
reader.SetFileName(source)
reader.Update()
image = vtkImageData()
image.ShallowCopy(reader.GetOutput())
image.SetOrigin(0, 0, 0)  # so that the mesh has the coordinates of the voxels, as the shapes do
image.SetSpacing(1, 1, 1)
image.SetDirectionMatrix(1, 0, 0, 0, 1, 0, 0, 0, 1)
edges = vtkDiscreteFlyingEdges3D()
edges.SetInputData(image)
edges.SetValue(0, 1)
edges.ComputeScalarsOff()
smooth = vtkWindowedSincPolyDataFilter()
smooth.SetInputConnection(edges.GetOutputPort())
smooth.SetNumberOfIterations(int(iterations))
smooth.SetPassBand(float(band))
smooth.BoundarySmoothingOff()
smooth.FeatureEdgeSmoothingOff()
smooth.NonManifoldSmoothingOn()
smooth.NormalizeCoordinatesOn()
writer = vtkPLYWriter()
writer.SetInputConnection((smooth if int(iterations) else edges).GetOutputPort())
writer.SetFileName(target)
writer.Write()
