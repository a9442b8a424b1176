# Build helpers: one static library per folder, one test program per folder of tests, the same warnings everywhere.

find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(fmt REQUIRED)
pkg_check_modules(EIGEN3 REQUIRED IMPORTED_TARGET eigen3)

# OpenCV's own package file asks for every module; the product uses core and imgproc alone.
find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
find_library(OPENCV_CORE_LIBRARY opencv_core REQUIRED)
find_library(OPENCV_IMGPROC_LIBRARY opencv_imgproc REQUIRED)
add_library(ninedot_opencv INTERFACE)
target_include_directories(ninedot_opencv SYSTEM INTERFACE ${OPENCV_INCLUDE_DIR})
target_link_libraries(ninedot_opencv INTERFACE ${OPENCV_IMGPROC_LIBRARY} ${OPENCV_CORE_LIBRARY})

add_library(ninedot_options INTERFACE)
target_include_directories(ninedot_options INTERFACE ${CMAKE_SOURCE_DIR} ${CMAKE_SOURCE_DIR}/firmware)
target_compile_options(ninedot_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wold-style-cast -Wnon-virtual-dtor
  -Woverloaded-virtual -Wcast-align -Wnull-dereference -Wimplicit-fallthrough)
# In instrumented code GCC takes the library's own locals for uninitialised (its bug 105562): a warning there is no error.
if(NINEDOT_WERROR AND NOT NINEDOT_SANITIZE)
  target_compile_options(ninedot_options INTERFACE -Werror)
endif()
# The expression templates of Eigen make GCC see null dereferences that do not exist.
target_compile_options(ninedot_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-null-dereference>)
target_link_libraries(ninedot_options INTERFACE Threads::Threads)
# The fuzzer follows the branches of everything that it tests; the sanitizers turn silent damage into a finding. The cast
# of a number that is too large, or none, to an integer is not among what `undefined` looks for.
if(NINEDOT_FUZZ)
  target_compile_options(ninedot_options INTERFACE -fsanitize=fuzzer-no-link)
endif()
if(NINEDOT_SANITIZE)
  target_compile_options(ninedot_options INTERFACE -fsanitize=${NINEDOT_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(ninedot_options INTERFACE -fsanitize=${NINEDOT_SANITIZE})
endif()

# Sanitized trees, and others where asked for, read the largest headers once: a third of their time. Whether each file
# includes what it needs, the other trees and clang-tidy tell.
if(NINEDOT_SANITIZE OR NINEDOT_SHARE_HEADERS)
  # Of a string that it read so, GCC 12 takes the buffer's first byte for one past its end.
  target_compile_options(ninedot_options INTERFACE
    $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-restrict;-Wno-stringop-overflow;-Wno-stringop-overread>)
  set(headers <Eigen/Dense> <algorithm> <chrono> <filesystem> <functional> <memory> <opencv2/core.hpp> <opencv2/imgproc.hpp>
    <optional> <ranges> <string> <vector>)
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/headers.cpp CONTENT "")
  set(sets_of_headers headers)
  if(NINEDOT_TESTS)
    find_package(GTest REQUIRED)
    list(APPEND sets_of_headers test_headers)
  endif()
  foreach(which IN LISTS sets_of_headers)
    add_library(ninedot_${which} OBJECT ${CMAKE_BINARY_DIR}/headers.cpp)
    target_link_libraries(ninedot_${which} PRIVATE ninedot_options ninedot_opencv PkgConfig::EIGEN3)
    target_precompile_headers(ninedot_${which} PRIVATE ${headers})
  endforeach()
  if(NINEDOT_TESTS)
    target_link_libraries(ninedot_test_headers PRIVATE GTest::gtest)
    target_precompile_headers(ninedot_test_headers PRIVATE <gtest/gtest.h>)
  endif()
endif()
# ninedot_reads_once(NAME headers | test_headers)
function(ninedot_reads_once name which)
  if(TARGET ninedot_${which})
    target_precompile_headers(${name} REUSE_FROM ninedot_${which})
  endif()
endfunction()

# ninedot_library(NAME DEPENDENCY...): the sources of the calling folder as one static library (header-only folders become INTERFACE).
function(ninedot_library name)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "_(main|test)\\.cpp$")
  if(sources)
    add_library(${name} STATIC ${sources})
    target_link_libraries(${name} PUBLIC ninedot_options ${ARGN})
    ninedot_reads_once(${name} headers)
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE ninedot_options ${ARGN})
  endif()
endfunction()
