#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
set -euo pipefail
enable=ON
[ "${mpi:-nompi}" != nompi ] || enable=OFF
# shellcheck disable=SC2086 # CMAKE_ARGS holds several
cmake -G Ninja -S . -B build ${CMAKE_ARGS:-} -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$PREFIX" -DSC_ENABLE_MPI=$enable \
    -DSC_WITH_DICOM=ON -DSC_WITH_HDF5=ON -DBUILD_TESTING=OFF
cmake --build build
cmake --install build
