# What a person who installs the program gets beside it: pages of the manual and completion for
# shells, both written by the program itself, and by `cpack` all of it as a package of Debian.
set(pages ${CMAKE_CURRENT_BINARY_DIR}/pages)
add_custom_command(OUTPUT ${pages}/stamp
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${pages}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${pages}
    COMMAND knead help --pages ${pages}
    COMMAND ${CMAKE_COMMAND} -E touch ${pages}/stamp
    DEPENDS knead VERBATIM)
add_custom_target(knead_pages ALL DEPENDS ${pages}/stamp)
set(zsh_completions zsh/site-functions)
if(EXISTS /etc/debian_version)
    set(zsh_completions zsh/vendor-completions)
endif()
install(DIRECTORY ${pages}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
install(FILES ${pages}/knead.bash RENAME knead COMPONENT program
    DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES ${pages}/_knead DESTINATION ${CMAKE_INSTALL_DATADIR}/${zsh_completions}
    COMPONENT program)
# As in the tree, so that their links hold.
install(FILES README.md CONTRIBUTING.md SECURITY.md CITATION.cff DESTINATION
    ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program
    FILES_MATCHING PATTERN "*.md" PATTERN "*.png" PATTERN "*.gif")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME knead)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Clay shaped by tracked hands")
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION
    "Knead simulates elastoplastic clay by the material point method, on an NVIDIA
GPU or on the CPU, and lets tracked hands and the tools they hold press,
pinch, cut and squeeze it. Clouds of Gaussian splats are clay, too.")
set(CPACK_PACKAGE_CONTACT "The Knead authors <knead@example.org>" CACHE STRING
    "Who maintains packages that are built here: Name <address>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
# Of all that is installed the program alone; the libraries and headers are for builds.
set(CPACK_COMPONENTS_ALL program)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME knead)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "libegl1, libgl1-mesa-dri, ffmpeg, fonts-dejavu-core")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "python3-matplotlib")
# What Debian asks of every package.
find_program(GZIP_PROGRAM gzip)
if(GZIP_PROGRAM)
    set(changelog ${CMAKE_CURRENT_BINARY_DIR}/changelog.gz)
    add_custom_command(OUTPUT ${changelog} DEPENDS ${PROJECT_SOURCE_DIR}/CHANGELOG.md VERBATIM
        COMMAND ${GZIP_PROGRAM} -9nc ${PROJECT_SOURCE_DIR}/CHANGELOG.md > ${changelog})
    add_custom_target(knead_changelog ALL DEPENDS ${changelog})
    install(FILES ${changelog} DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/knead COMPONENT program)
    add_custom_command(OUTPUT ${pages}/stamp APPEND
        COMMAND sh -c "${GZIP_PROGRAM} -9n ${pages}/man/*.1")
endif()
install(FILES cmake/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/knead COMPONENT program)
include(CPack)
