#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Writes the files of this folder with Connectome Workbench 1.5.0 (Debian: connectome-workbench), from voxels of nibabel. Run
# once, in an empty folder; the tests read what it has written.
set -e
python3 -c '
import nibabel, numpy
labels = numpy.zeros((8, 9, 10), numpy.int16)
labels[1:4, 2:7, 2:8] = 17
labels[4:7, 1:6, 1:5] = 53
nibabel.save(nibabel.Nifti1Image(labels, numpy.diag([2, 2, 2.5, 1])), "voxels.nii.gz")'
printf 'Left-Hippocampus\n17 220 216 20 255\nRight Hippocampus & more\n53 10 20 230 128\n' >list.txt
wb_command -volume-label-import voxels.nii.gz list.txt labels.nii.gz
wb_command -volume-label-export-table labels.nii.gz 1 table.txt
