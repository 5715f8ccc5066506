# SPDX-License-Identifier: BSD-3-Clause
# What segcast is built from: one list, which `segcast --version --json` prints and from which the bill of materials
# (segcast.spdx.json, SPDX 2.3) is written when the build is configured. The same sources and libraries give the same bytes.

# segcast_note(NAME VERSION LICENCE): segcast links this library; VERSION may be empty: unknown.
set(SC_BILL "")
macro(segcast_note name version licence)
  list(APPEND SC_BILL "${name}|${version}|${licence}")
endmacro()
segcast_note(libpng "${PNG_VERSION_STRING}" libpng-2.0)
segcast_note(zlib "${ZLIB_VERSION_STRING}${ZLIB_VERSION}" Zlib)
segcast_note(libyaml "${YAML_VERSION}" MIT)
segcast_note(jansson "${JANSSON_VERSION}" MIT)
segcast_note(cairo "${CAIRO_cairo_VERSION}" "LGPL-2.1-only OR MPL-1.1")
segcast_note(fontconfig "${FONTCONFIG_VERSION}" NOASSERTION)
segcast_note(xxhash "${XXHASH_VERSION}" BSD-2-Clause)
foreach(part libavformat libavcodec libavutil libswscale)
  segcast_note(${part} "${LIBAV_${part}_VERSION}" NOASSERTION) # LGPL or GPL, as its distributor has built it
endforeach()
segcast_note(libavfilter "${LIBAVFILTER_VERSION}" NOASSERTION)
string(REGEX REPLACE "^([0-9])([0-9][0-9])([0-9][0-9])$" "\\1.\\2.\\3" teem_version "${TEEM_VERSION}")
string(REPLACE ".0" "." teem_version "${teem_version}")
segcast_note(teem "${teem_version}" NOASSERTION)
segcast_note(nifti2 "" NOASSERTION)
if(SC_ENABLE_MPI)
  segcast_note(mpi "${MPI_C_VERSION}" NOASSERTION) # the version of the standard; the library is told where segcast runs
endif()
if(EXPAT_FOUND)
  segcast_note(expat "${EXPAT_VERSION_STRING}" MIT)
endif()
if(TIFF_FOUND)
  segcast_note(libtiff "${TIFF_VERSION}" libtiff)
endif()
if(meshoptimizer_FOUND)
  segcast_note(meshoptimizer "${meshoptimizer_VERSION}" MIT)
endif()
if(BLOSC_FOUND)
  segcast_note(blosc "${BLOSC_VERSION}" BSD-3-Clause)
endif()
if(ZSTD_FOUND)
  segcast_note(zstd "${ZSTD_VERSION}" "BSD-3-Clause OR GPL-2.0-only")
endif()
if(LZ4_FOUND)
  segcast_note(lz4 "${LZ4_VERSION}" BSD-2-Clause)
endif()
if(SC_HAVE_DICOM)
  string(REGEX REPLACE "^([0-9])([0-9])([0-9])$" "\\1.\\2.\\3" version "${DCMTK_VERSION}")
  segcast_note(dcmtk "${version}" NOASSERTION)
endif()
if(SC_HAVE_HDF5)
  foreach(part MAJOR MINOR RELEASE)
    segcast_read_version(HDF5_${part} ${HDF5_INCLUDE_DIR}/H5public.h H5_VERS_${part})
  endforeach()
  segcast_note(hdf5 "${HDF5_MAJOR}.${HDF5_MINOR}.${HDF5_RELEASE}" NOASSERTION)
endif()

# The list as JSON, for the program; and as packages and relationships of SPDX.
set(libraries "")
set(packages "")
set(relations "")
foreach(entry IN LISTS SC_BILL)
  string(REPLACE "|" ";" entry "${entry};")
  list(GET entry 0 name)
  list(GET entry 1 version)
  list(GET entry 2 licence)
  string(APPEND libraries ",\"${name}\":\"${version}\"")
  set(version_line "")
  if(version)
    set(version_line "\"versionInfo\": \"${version}\", ")
  endif()
  string(APPEND packages ",
    {\"SPDXID\": \"SPDXRef-${name}\", \"name\": \"${name}\", ${version_line}\"downloadLocation\": \"NOASSERTION\",
     \"filesAnalyzed\": false, \"licenseConcluded\": \"NOASSERTION\", \"licenseDeclared\": \"${licence}\", \"copyrightText\": \"NOASSERTION\"}")
  string(APPEND relations ",
    {\"spdxElementId\": \"SPDXRef-segcast\", \"relationshipType\": \"DYNAMIC_LINK\", \"relatedSpdxElement\": \"SPDXRef-${name}\"}")
endforeach()
string(SUBSTRING "${libraries}" 1 -1 libraries)

# segcast_is(NAME CONDITION...): an option of the build as JSON.
set(options "")
macro(segcast_is name)
  if(${ARGN})
    string(APPEND options ",\"${name}\":true")
  else()
    string(APPEND options ",\"${name}\":false")
  endif()
endmacro()
segcast_is(mpi SC_ENABLE_MPI)
segcast_is(dicom SC_HAVE_DICOM)
segcast_is(hdf5 SC_HAVE_HDF5)
segcast_is(tiff TIFF_FOUND)
segcast_is(xml EXPAT_FOUND)
segcast_is(gif LIBAVFILTER_FOUND)
segcast_is(simplify meshoptimizer_FOUND)
segcast_is(blosc BLOSC_FOUND)
segcast_is(zstd ZSTD_FOUND)
segcast_is(lz4 LZ4_FOUND)
segcast_is(rivals NOT DEFINED SC_RIVALS OR SC_RIVALS)
string(SUBSTRING "${options}" 1 -1 options)
set(SC_BUILD_JSON "{\"compiler\":\"${CMAKE_C_COMPILER_ID} ${CMAKE_C_COMPILER_VERSION}\",\"build_type\":\"${CMAKE_BUILD_TYPE}\",\"processor\":\"${CMAKE_SYSTEM_PROCESSOR}\",\"options\":{${options}},\"libraries\":{${libraries}}}")
string(REPLACE "\"" "\\\"" SC_BUILD_JSON_C "${SC_BUILD_JSON}")

# The time of the bill is that of the sources (SOURCE_DATE_EPOCH, or the commit), so that two builds write the same bytes.
function(segcast_write_bill)
  set(time "")
  if(NOT DEFINED ENV{SOURCE_DATE_EPOCH} AND NOT SC_COMMIT STREQUAL "unknown")
    execute_process(COMMAND ${GIT_PROGRAM} --git-dir=${PROJECT_SOURCE_DIR}/.git log -1 --format=%ct
      OUTPUT_VARIABLE time OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    set(ENV{SOURCE_DATE_EPOCH} "${time}") # which string(TIMESTAMP) obeys
  endif()
  string(TIMESTAMP created "%Y-%m-%dT%H:%M:%SZ" UTC)
  if(time)
    unset(ENV{SOURCE_DATE_EPOCH})
  endif()
  string(UUID id NAMESPACE 6ba7b811-9dad-11d1-80b4-00c04fd430c8 NAME "segcast ${PROJECT_VERSION} ${SC_COMMIT} ${SC_BUILD_JSON}" TYPE SHA1)
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/segcast.spdx.json @ONLY CONTENT [[{
  "spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT", "name": "segcast-@PROJECT_VERSION@",
  "documentNamespace": "urn:uuid:@id@",
  "creationInfo": {"created": "@created@", "creators": ["Tool: segcast-build-@PROJECT_VERSION@"]},
  "documentDescribes": ["SPDXRef-segcast"],
  "packages": [
    {"SPDXID": "SPDXRef-segcast", "name": "segcast", "versionInfo": "@PROJECT_VERSION@", "sourceInfo": "commit @SC_COMMIT@", "downloadLocation": "NOASSERTION",
     "filesAnalyzed": false, "licenseConcluded": "BSD-3-Clause", "licenseDeclared": "BSD-3-Clause", "copyrightText": "The segcast authors"}@packages@
  ],
  "relationships": [
    {"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES", "relatedSpdxElement": "SPDXRef-segcast"}@relations@
  ]
}
]])
  install(FILES ${PROJECT_BINARY_DIR}/segcast.spdx.json DESTINATION ${CMAKE_INSTALL_DOCDIR})
endfunction()
