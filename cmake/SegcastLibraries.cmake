# SPDX-License-Identifier: BSD-3-Clause
# The libraries that segcast uses, with the oldest versions that have what it calls (Debian 12 and newer are
# tested). A library is linked only by the modules whose CMakeLists.txt names it.
find_package(PkgConfig REQUIRED)
find_package(OpenMP REQUIRED COMPONENTS C)
find_package(Threads REQUIRED)
find_package(PNG 1.6 REQUIRED)
find_package(ZLIB 1.2.11 REQUIRED)
find_package(JPEG REQUIRED)
if(SC_ENABLE_MPI)
  find_package(MPI 3.0 COMPONENTS C)
  if(NOT MPI_C_FOUND)
    message(FATAL_ERROR "There is no MPI library of version 3.0 or newer for the C compiler. Install one "
      "(Debian: libopenmpi-dev), name its compiler by -DMPI_C_COMPILER=..., or build segcast for one process: "
      "cmake --preset nompi")
  endif()
endif()
pkg_check_modules(YAML REQUIRED IMPORTED_TARGET yaml-0.1>=0.2.2)
pkg_check_modules(JANSSON REQUIRED IMPORTED_TARGET jansson>=2.13)
pkg_check_modules(CAIRO REQUIRED IMPORTED_TARGET cairo>=1.16 cairo-ft>=1.16)
pkg_check_modules(FONTCONFIG REQUIRED IMPORTED_TARGET fontconfig>=2.13)
pkg_check_modules(MICROHTTPD REQUIRED IMPORTED_TARGET libmicrohttpd>=0.9.75)
pkg_check_modules(XXHASH REQUIRED IMPORTED_TARGET libxxhash>=0.8.0)
# FFmpeg 4.4
pkg_check_modules(LIBAV REQUIRED IMPORTED_TARGET libavformat>=58.76 libavcodec>=58.134 libavutil>=56.70
  libswscale>=5.9)
pkg_check_modules(LIBAVFILTER REQUIRED IMPORTED_TARGET libavfilter>=7.110)

# Optional: label tables in XML. SC_HAVE_EXPAT tells the code.
find_package(EXPAT 2.2)
add_library(Expat::expat INTERFACE IMPORTED)
if(EXPAT_FOUND)
  target_link_libraries(Expat::expat INTERFACE EXPAT::EXPAT)
  target_compile_definitions(Expat::expat INTERFACE SC_HAVE_EXPAT=1)
else()
  message(WARNING "Expat is not here (Debian: libexpat1-dev): label tables in XML, among them the names that "
    "TotalSegmentator writes into NIfTI files, will not be read")
  target_compile_definitions(Expat::expat INTERFACE SC_HAVE_EXPAT=0)
endif()

# Optional: volumes in TIFF. SC_HAVE_TIFF tells the code. From 4.5 on messages can be caught for each file.
pkg_check_modules(TIFF IMPORTED_TARGET libtiff-4>=4.5)
add_library(Tiff::tiff INTERFACE IMPORTED)
if(TIFF_FOUND)
  target_link_libraries(Tiff::tiff INTERFACE PkgConfig::TIFF)
  target_compile_definitions(Tiff::tiff INTERFACE SC_HAVE_TIFF=1)
else()
  message(WARNING "libtiff 4.5 or newer is not here (Debian: libtiff-dev): volumes in TIFF will not be read")
  target_compile_definitions(Tiff::tiff INTERFACE SC_HAVE_TIFF=0)
endif()

# Optional: meshes of fewer triangles. SC_HAVE_MESHOPTIMIZER tells the code. From 0.18 on its scale of errors can be asked for.
find_package(meshoptimizer 0.18 QUIET CONFIG)
add_library(Meshoptimizer::meshoptimizer INTERFACE IMPORTED)
if(meshoptimizer_FOUND)
  target_link_libraries(Meshoptimizer::meshoptimizer INTERFACE meshoptimizer::meshoptimizer)
  target_compile_definitions(Meshoptimizer::meshoptimizer INTERFACE SC_HAVE_MESHOPTIMIZER=1)
else()
  message(WARNING "meshoptimizer 0.18 or newer is not here (Debian: libmeshoptimizer-dev): meshes cannot be simplified")
  target_compile_definitions(Meshoptimizer::meshoptimizer INTERFACE SC_HAVE_MESHOPTIMIZER=0)
endif()

# Optional: codecs of Zarr. SC_HAVE_BLOSC, SC_HAVE_ZSTD and SC_HAVE_LZ4 tell the code.
# segcast_add_codec(TARGET MACRO MODULE PACKAGE): TARGET links what pkg-config knows as MODULE, if it is there.
function(segcast_add_codec target macro module package)
  pkg_check_modules(${macro} IMPORTED_TARGET GLOBAL ${module})
  add_library(${target} INTERFACE IMPORTED GLOBAL)
  if(${macro}_FOUND)
    target_link_libraries(${target} INTERFACE PkgConfig::${macro})
    target_compile_definitions(${target} INTERFACE SC_HAVE_${macro}=1)
  else()
    message(WARNING "${module} is not here (Debian: ${package}): Zarr volumes compressed by it will not be read")
    target_compile_definitions(${target} INTERFACE SC_HAVE_${macro}=0)
  endif()
endfunction()
segcast_add_codec(Blosc::blosc BLOSC blosc>=1.21 libblosc-dev)
segcast_add_codec(Zstd::zstd ZSTD libzstd>=1.4 libzstd-dev)
segcast_add_codec(Lz::lz4 LZ4 liblz4>=1.9 liblz4-dev)

# segcast_read_version(VARIABLE FILE MACRO): the number that a header defines as MACRO; 0 if it does not.
function(segcast_read_version variable file macro)
  set(line)
  if(EXISTS ${file})
    file(STRINGS ${file} line REGEX "^ *# *define +${macro} +[0-9]+" LIMIT_COUNT 1)
  endif()
  string(REGEX REPLACE "^.*${macro} +([0-9]+).*$" "\\1" number "${line}")
  if(NOT number)
    set(number 0)
  endif()
  set(${variable} ${number} PARENT_SCOPE)
endfunction()

# Optional: DICOM segmentations, by DCMTK, which is C++. SC_HAVE_DICOM tells the code. DCMTK's own CMake and pkg-config
# files name all of its libraries and what these link: look for the three that are used.
add_library(Dcmtk::dcmdata INTERFACE IMPORTED)
set(SC_HAVE_DICOM 0)
if(NOT SC_WITH_DICOM STREQUAL "OFF")
  include(CheckLanguage)
  check_language(CXX)
  find_path(DCMTK_INCLUDE_DIR dcmtk/dcmdata/dctk.h)
  segcast_read_version(DCMTK_VERSION ${DCMTK_INCLUDE_DIR}/dcmtk/config/osconfig.h PACKAGE_VERSION_NUMBER)
  find_library(DCMTK_DCMDATA_LIBRARY dcmdata)
  find_library(DCMTK_OFLOG_LIBRARY oflog)
  find_library(DCMTK_OFSTD_LIBRARY ofstd)
  if(CMAKE_CXX_COMPILER AND DCMTK_VERSION GREATER_EQUAL 367 AND DCMTK_DCMDATA_LIBRARY AND DCMTK_OFLOG_LIBRARY AND DCMTK_OFSTD_LIBRARY)
    enable_language(CXX)
    set(SC_HAVE_DICOM 1)
    target_include_directories(Dcmtk::dcmdata SYSTEM INTERFACE ${DCMTK_INCLUDE_DIR})
    target_link_libraries(Dcmtk::dcmdata INTERFACE ${DCMTK_DCMDATA_LIBRARY} ${DCMTK_OFLOG_LIBRARY} ${DCMTK_OFSTD_LIBRARY})
  elseif(SC_WITH_DICOM STREQUAL "ON")
    message(FATAL_ERROR "DCMTK 3.6.7 or newer or a C++ compiler is not here (Debian: libdcmtk-dev, g++), and SC_WITH_DICOM is ON")
  else()
    message(WARNING "DCMTK 3.6.7 or newer or a C++ compiler is not here (Debian: libdcmtk-dev, g++): DICOM segmentations will not be read")
  endif()
endif()
target_compile_definitions(Dcmtk::dcmdata INTERFACE SC_HAVE_DICOM=${SC_HAVE_DICOM})

# Optional: volumes in HDF5, read by a program of its own. SC_HAVE_HDF5 tells the code. A library that needs MPI does not
# fit: the program is no rank. H5_USE_110_API: newer versions keep what version 1.10 has.
add_library(Hdf::hdf5 INTERFACE IMPORTED)
set(SC_HAVE_HDF5 0)
if(NOT SC_WITH_HDF5 STREQUAL "OFF")
  pkg_check_modules(HDF5_SERIAL hdf5-serial) # Debian's name beside libraries that need MPI
  find_path(HDF5_INCLUDE_DIR hdf5.h HINTS ${HDF5_SERIAL_INCLUDE_DIRS})
  find_library(HDF5_LIBRARY hdf5 HINTS ${HDF5_SERIAL_LIBRARY_DIRS})
  if(HDF5_INCLUDE_DIR AND HDF5_LIBRARY)
    include(CheckCSourceCompiles)
    set(CMAKE_REQUIRED_INCLUDES ${HDF5_INCLUDE_DIR})
    set(CMAKE_REQUIRED_LIBRARIES ${HDF5_LIBRARY})
    check_c_source_compiles("#include <hdf5.h>
      #if defined(H5_HAVE_PARALLEL) || !H5_VERSION_GE(1, 10, 0)
      #error
      #endif
      int main(void) { return H5open(); }" SC_HDF5_FITS)
    unset(CMAKE_REQUIRED_INCLUDES)
    unset(CMAKE_REQUIRED_LIBRARIES)
  endif()
  if(SC_HDF5_FITS)
    set(SC_HAVE_HDF5 1)
    target_include_directories(Hdf::hdf5 SYSTEM INTERFACE ${HDF5_INCLUDE_DIR})
    target_link_libraries(Hdf::hdf5 INTERFACE ${HDF5_LIBRARY})
    target_compile_definitions(Hdf::hdf5 INTERFACE H5_USE_110_API=1)
  elseif(SC_WITH_HDF5 STREQUAL "ON")
    message(FATAL_ERROR "libhdf5 1.10 or newer, built without MPI, is not here (Debian: libhdf5-dev), and SC_WITH_HDF5 is ON")
  else()
    message(WARNING "libhdf5 1.10 or newer, built without MPI, is not here (Debian: libhdf5-dev): volumes in HDF5 will not be read")
  endif()
endif()
add_library(segcast_hdf5_answers INTERFACE) # for those who start that program
target_compile_definitions(segcast_hdf5_answers INTERFACE SC_HAVE_HDF5=${SC_HAVE_HDF5})
# Where programs and modules are installed that segcast starts or loads; src/base knows it.
set(SC_PROGRAMS_DIR ${CMAKE_INSTALL_LIBEXECDIR}/segcast)

# Teem and nifticlib install CMake files that differ between versions: look for the library itself. nifticlib does not say
# its version; the library nifti2 came with 3.0.
find_path(TEEM_INCLUDE_DIR teem/nrrd.h REQUIRED)
segcast_read_version(TEEM_VERSION ${TEEM_INCLUDE_DIR}/teem/air.h TEEM_VERSION)
if(TEEM_VERSION LESS 11200)
  message(FATAL_ERROR "Teem in ${TEEM_INCLUDE_DIR} has the version ${TEEM_VERSION}, expected 11200 (1.12) or newer; "
    "Debian: libteem-dev")
endif()
find_library(TEEM_LIBRARY teem REQUIRED)
add_library(Teem::teem INTERFACE IMPORTED)
target_include_directories(Teem::teem SYSTEM INTERFACE ${TEEM_INCLUDE_DIR})
target_link_libraries(Teem::teem INTERFACE ${TEEM_LIBRARY} m)

find_path(NIFTI2_INCLUDE_DIR nifti2_io.h PATH_SUFFIXES nifti REQUIRED)
find_library(NIFTI2_LIBRARY nifti2 REQUIRED)
add_library(Nifti::nifti2 INTERFACE IMPORTED)
target_include_directories(Nifti::nifti2 SYSTEM INTERFACE ${NIFTI2_INCLUDE_DIR})
target_link_libraries(Nifti::nifti2 INTERFACE ${NIFTI2_LIBRARY} ZLIB::ZLIB m)
