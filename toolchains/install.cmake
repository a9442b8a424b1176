# What is installed where, and the two Debian packages made of it. The presets have the prefix /usr.
include(GNUInstallDirs)

# The service, package ninedot.
install(TARGETS ninedot ninedotd RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT service)
install(FILES systemd/ninedotd.service DESTINATION lib/systemd/system COMPONENT service)
install(FILES systemd/ninedot.sysusers DESTINATION lib/sysusers.d RENAME ninedot.conf COMPONENT service)
install(FILES systemd/ninedot.tmpfiles DESTINATION lib/tmpfiles.d RENAME ninedot.conf COMPONENT service)
install(FILES systemd/60-ninedot.rules DESTINATION lib/udev/rules.d COMPONENT service)
install(FILES systemd/ninedot.toml DESTINATION ${CMAKE_INSTALL_FULL_SYSCONFDIR}/ninedot COMPONENT service)
install(DIRECTORY tests/recordings/approach DESTINATION ${CMAKE_INSTALL_DATADIR}/ninedot/recordings COMPONENT service)
install(DIRECTORY docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs COMPONENT service)
install(FILES README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT service)
install(FILES systemd/package/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT service)

# The page, package ninedot-web: nothing of it is where only the service is wanted.
install(TARGETS ninedot-web RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT web)
install(FILES systemd/ninedot-web.service systemd/ninedot-apply.socket systemd/ninedot-apply@.service DESTINATION lib/systemd/system COMPONENT web)
install(FILES systemd/ninedot-web.sysusers DESTINATION lib/sysusers.d RENAME ninedot-web.conf COMPONENT web)
install(FILES systemd/package/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/ninedot-web COMPONENT web)
get_property(NINEDOT_AR_LICENCE GLOBAL PROPERTY NINEDOT_AR_LICENCE)
if(NINEDOT_AR_LICENCE)
  install(FILES ${NINEDOT_AR_LICENCE} DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/ninedot-web RENAME copyright.three.js COMPONENT web)
endif()

set(NINEDOT_PACKAGE_REVISION 1 CACHE STRING "Debian revision of the package")
set(NINEDOT_MAINTAINER "The ninedot developers <maintainers@ninedot.invalid>")

# Debian's form of a change log, which leads to ours. Dated by the sources, so that they give the same bytes whenever they are packed.
if(NOT DEFINED ENV{SOURCE_DATE_EPOCH})
  execute_process(COMMAND git -c safe.directory=* log -1 --format=%ct WORKING_DIRECTORY ${CMAKE_SOURCE_DIR} OUTPUT_VARIABLE NINEDOT_EPOCH
                  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(NINEDOT_EPOCH MATCHES "^[0-9]+$")
    set(ENV{SOURCE_DATE_EPOCH} ${NINEDOT_EPOCH})
  endif()
endif()
string(TIMESTAMP NINEDOT_DATE "%a, %d %b %Y %H:%M:%S +0000" UTC)
foreach(package ninedot ninedot-web)
  set(place ${CMAKE_BINARY_DIR}/debian/${package})
  file(WRITE ${place}/changelog.Debian "${package} (${PROJECT_VERSION}-${NINEDOT_PACKAGE_REVISION}) unstable; urgency=medium

  * What changed is told in /usr/share/doc/ninedot/CHANGELOG.md.

 -- ${NINEDOT_MAINTAINER}  ${NINEDOT_DATE}
")
  execute_process(COMMAND gzip -9nkf ${place}/changelog.Debian COMMAND_ERROR_IS_FATAL ANY)
endforeach()
install(FILES ${CMAKE_BINARY_DIR}/debian/ninedot/changelog.Debian.gz DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT service)
install(FILES ${CMAKE_BINARY_DIR}/debian/ninedot-web/changelog.Debian.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/ninedot-web COMPONENT web)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ninedot)
set(CPACK_PACKAGE_CONTACT "${NINEDOT_MAINTAINER}")
set(CPACK_COMPONENTS_ALL service web)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_SERVICE_PACKAGE_NAME ninedot)
set(CPACK_DEBIAN_WEB_PACKAGE_NAME ninedot-web)
set(CPACK_DEBIAN_SERVICE_DESCRIPTION "position sensor: six degrees of freedom from a printed landmark, over Modbus
A camera that watches a printed nine-dot landmark becomes a position sensor:
ninedotd finds the landmark in every frame, computes the camera's pose with
its uncertainty and serves it to robot controllers over Modbus RTU and TCP.")
set(CPACK_DEBIAN_WEB_DESCRIPTION "page of the position sensor ninedot, for a browser
ninedot-web shows what a running ninedotd sees and how it is: picture, health,
registers and map. It is a process and a user of its own, disabled until it is
enabled.")
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/package)
set(CPACK_STRIP_FILES ON)
set(CPACK_SET_DESTDIR ON)  # the configuration is at an absolute place, /etc
set(CPACK_INSTALL_PREFIX ${CMAKE_INSTALL_PREFIX})
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_RELEASE ${NINEDOT_PACKAGE_REVISION})
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_SERVICE_PACKAGE_DEPENDS "systemd")
set(CPACK_DEBIAN_WEB_PACKAGE_DEPENDS "ninedot (= ${PROJECT_VERSION}-${NINEDOT_PACKAGE_REVISION}), systemd")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_SERVICE_PACKAGE_CONTROL_EXTRA
    ${CMAKE_SOURCE_DIR}/systemd/package/conffiles ${CMAKE_SOURCE_DIR}/systemd/package/postinst
    ${CMAKE_SOURCE_DIR}/systemd/package/prerm ${CMAKE_SOURCE_DIR}/systemd/package/postrm)
set(CPACK_DEBIAN_WEB_PACKAGE_CONTROL_EXTRA
    ${CMAKE_SOURCE_DIR}/systemd/package-web/postinst ${CMAKE_SOURCE_DIR}/systemd/package-web/prerm
    ${CMAKE_SOURCE_DIR}/systemd/package-web/postrm)
include(CPack)
