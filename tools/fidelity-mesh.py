#!/usr/bin/python3
"""A mesh of label 1 of a NRRD volume as 3D Slicer makes it, for tools/fidelity: discrete flying
edges, windowed sinc smoothing. usage: fidelity-mesh.py IN.nrrd OUT.ply ITERATIONS PASS_BAND"""
import sys

# By module: "all" brings in readers that want MPI.
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
image.SetOrigin(0, 0, 0)  # the shapes are measured in voxels
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
