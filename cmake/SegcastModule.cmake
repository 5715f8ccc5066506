# SPDX-License-Identifier: BSD-3-Clause
# segcast_add_module(NAME SOURCES file... [USES target...])
#
# One static library per module of src/. USES names the modules and libraries that it may include
# from and links. tests/style/floors.sh checks that a module uses only those that stand before it in
# src/CMakeLists.txt.

add_library(segcast_options INTERFACE)
target_compile_features(segcast_options INTERFACE c_std_17)
# No fused multiply-add and no fast-math: pixels must not depend on compiler or processor.
target_compile_options(segcast_options INTERFACE
  -Wall -Wextra -Wshadow $<$<COMPILE_LANGUAGE:C>:-Wstrict-prototypes> $<$<COMPILE_LANGUAGE:C>:-Wmissing-prototypes>
  # A function that is called by its address has the parameters of its type, also those that it has no use for.
  -Wno-unused-parameter -Wpointer-arith -Wvla -Wundef -Wformat=2 -ffp-contract=off -fno-math-errno -fno-trapping-math
  $<$<BOOL:${SC_WERROR}>:-Werror>)
target_compile_definitions(segcast_options INTERFACE _XOPEN_SOURCE=700)
target_include_directories(segcast_options INTERFACE ${PROJECT_SOURCE_DIR}/include)
# What reads files of others ends at the first write beyond an array, and what the loader has filled in stays read-only.
target_compile_options(segcast_options INTERFACE -fstack-protector-strong)
target_link_options(segcast_options INTERFACE LINKER:-z,relro,-z,now)
if(NOT SC_SANITIZE) # sanitizers check more
  target_compile_options(segcast_options INTERFACE
    $<$<NOT:$<CONFIG:Debug>>:-U_FORTIFY_SOURCE> $<$<NOT:$<CONFIG:Debug>>:-D_FORTIFY_SOURCE=2>)
endif()
if(SC_SANITIZE)
  target_compile_options(segcast_options INTERFACE
    -fsanitize=${SC_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(segcast_options INTERFACE -fsanitize=${SC_SANITIZE})
endif()

function(segcast_add_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;USES" ${ARGN})
  add_library(sc_${name} STATIC ${ARG_SOURCES})
  target_include_directories(sc_${name} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  target_link_libraries(sc_${name} PUBLIC segcast_options)
  foreach(use IN LISTS ARG_USES)
    if(TARGET sc_${use})
      target_link_libraries(sc_${name} PUBLIC sc_${use})
    else()
      target_link_libraries(sc_${name} PRIVATE ${use})
    endif()
  endforeach()
endfunction()
