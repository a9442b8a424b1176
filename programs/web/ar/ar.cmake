# three.js for the page's view AR, as one file: made where `./dev ar` has fetched it, and nowhere else, for building downloads nothing.
# NINEDOT_AR_BUNDLE: that file, or the one in its place that says that it is missing. NINEDOT_AR_LICENCE: its licence, or nothing.
option(NINEDOT_AR "Build the page's view AR into ninedot-web, where ./dev ar has fetched what it needs" ON)
set(fetched ${CMAKE_CURRENT_LIST_DIR}/node_modules)
set(NINEDOT_AR_BUNDLE ${CMAKE_CURRENT_LIST_DIR}/absent/three.js)
set(NINEDOT_AR_LICENCE)
file(GLOB esbuild CONFIGURE_DEPENDS ${fetched}/@esbuild/linux-*/bin/esbuild)  # the program itself, which needs no Node.js
set(status 1)
if(NINEDOT_AR AND esbuild AND EXISTS ${fetched}/three/LICENSE)
  execute_process(COMMAND ${esbuild} --version RESULT_VARIABLE status OUTPUT_QUIET ERROR_QUIET)
endif()
if(status EQUAL 0)
  set(NINEDOT_AR_BUNDLE ${CMAKE_CURRENT_BINARY_DIR}/three.js)
  set(NINEDOT_AR_LICENCE ${fetched}/three/LICENSE)
  add_custom_command(OUTPUT ${NINEDOT_AR_BUNDLE}
    COMMAND ${CMAKE_COMMAND} -DESBUILD=${esbuild} -DENTRY=${CMAKE_CURRENT_LIST_DIR}/three.js -DLICENCE=${NINEDOT_AR_LICENCE}
      -DOUTPUT=${NINEDOT_AR_BUNDLE} -P ${CMAKE_CURRENT_LIST_DIR}/bundle.cmake
    DEPENDS ${CMAKE_CURRENT_LIST_DIR}/three.js ${CMAKE_CURRENT_LIST_DIR}/bundle.cmake ${fetched}/three/package.json ${esbuild} VERBATIM)
  message(STATUS "The page's view AR: built in")
else()
  message(STATUS "The page's view AR: left out; ./dev ar fetches what it needs")
endif()
