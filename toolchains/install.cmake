# What is installed where, and the Debian package made of it. `./dev package` configures with the prefix /usr.
include(GNUInstallDirs)

install(TARGETS ninedot ninedotd RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(FILES systemd/ninedotd.service DESTINATION lib/systemd/system)
install(FILES systemd/ninedot.sysusers DESTINATION lib/sysusers.d RENAME ninedot.conf)
install(FILES systemd/ninedot.tmpfiles DESTINATION lib/tmpfiles.d RENAME ninedot.conf)
install(FILES systemd/60-ninedot.rules DESTINATION lib/udev/rules.d)
install(FILES systemd/ninedot.toml DESTINATION ${CMAKE_INSTALL_FULL_SYSCONFDIR}/ninedot)
install(DIRECTORY tests/recordings/approach DESTINATION ${CMAKE_INSTALL_DATADIR}/ninedot/recordings)
install(DIRECTORY docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs)
install(FILES README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)

set(NINEDOT_PACKAGE_REVISION 1 CACHE STRING "Debian revision of the package")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ninedot)
set(CPACK_PACKAGE_CONTACT "The ninedot developers <ninedot@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "position sensor: six degrees of freedom from a printed landmark, over Modbus")
set(CPACK_PACKAGE_DESCRIPTION "A camera that watches a printed nine-dot landmark becomes a position sensor: ninedotd finds the landmark in
every frame, computes the camera's pose with its uncertainty and serves it to robot controllers over Modbus RTU and Modbus TCP.")
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/package)
set(CPACK_STRIP_FILES ON)
set(CPACK_SET_DESTDIR ON)  # the configuration is at an absolute place, /etc
set(CPACK_INSTALL_PREFIX ${CMAKE_INSTALL_PREFIX})
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_RELEASE ${NINEDOT_PACKAGE_REVISION})
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "systemd, init-system-helpers")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA
    ${CMAKE_SOURCE_DIR}/systemd/package/conffiles ${CMAKE_SOURCE_DIR}/systemd/package/postinst
    ${CMAKE_SOURCE_DIR}/systemd/package/prerm ${CMAKE_SOURCE_DIR}/systemd/package/postrm)
include(CPack)
