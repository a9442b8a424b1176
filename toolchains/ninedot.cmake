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

# Sanitized trees, and the tests where asked for, read the largest headers once: a third of their time. Whether each file of
# the product includes what it needs, the other trees tell.
if(NINEDOT_SANITIZE OR NINEDOT_TESTS_SHARE_HEADERS)
  find_package(GTest REQUIRED)
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/headers.cpp CONTENT "")
  add_library(ninedot_headers OBJECT ${CMAKE_BINARY_DIR}/headers.cpp)
  target_link_libraries(ninedot_headers PRIVATE ninedot_options ninedot_opencv PkgConfig::EIGEN3 GTest::gtest)
  target_precompile_headers(ninedot_headers PRIVATE <Eigen/Dense> <algorithm> <chrono> <filesystem> <functional> <gtest/gtest.h> <memory>
    <opencv2/core.hpp> <opencv2/imgproc.hpp> <optional> <ranges> <string> <vector>)
endif()
function(ninedot_headers_once name)
  if(TARGET ninedot_headers)
    target_precompile_headers(${name} REUSE_FROM ninedot_headers)
  endif()
endfunction()

# ninedot_library(NAME DEPENDENCY...): the sources of the calling folder as one static library (header-only folders become INTERFACE).
function(ninedot_library name)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "_(main|test)\\.cpp$")
  if(sources)
    add_library(${name} STATIC ${sources})
    target_link_libraries(${name} PUBLIC ninedot_options ${ARGN})
    if(NINEDOT_SANITIZE)
      ninedot_headers_once(${name})
    endif()
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE ninedot_options ${ARGN})
  endif()
endfunction()
