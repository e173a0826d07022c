# The libraries, the headers below include/knead as they lie here, and what find_package(Knead)
# reads.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(headers ${CMAKE_INSTALL_INCLUDEDIR}/knead)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/Knead)

install(TARGETS knead_solver knead_app EXPORT KneadTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} INCLUDES DESTINATION ${headers})
install(EXPORT KneadTargets NAMESPACE Knead:: DESTINATION ${package})
# Not those of the back ends, nor of the program.
install(DIRECTORY cuda host DESTINATION ${headers} FILES_MATCHING PATTERN *.h PATTERN *.cuh
    PATTERN host/cli EXCLUDE PATTERN host/desktop EXCLUDE PATTERN host/solver/cpu EXCLUDE
    PATTERN host/solver/gpu EXCLUDE PATTERN host/solver/pieces.h EXCLUDE
    PATTERN host/vr/panel_quad.h EXCLUDE PATTERN host/vr/headset_feel.h EXCLUDE
    PATTERN host/vr/headset_loop_class.h EXCLUDE)
install(FILES render/painter.h render/geometry.h render/eye_painter.h render/pace.h
    DESTINATION ${headers}/render)
install(FILES xr/headset.h DESTINATION ${headers}/xr)

# What `knead bench` compares with, what `knead verify` knows of, and what both draw by.
install(FILES profiling/plot.py profiling/plot_verify.py profiling/known.json profiling/peers.json
    profiling/targets.json
    DESTINATION ${CMAKE_INSTALL_DATADIR}/knead/profiling COMPONENT program)
install(FILES profiling/peers/taichi_mpm.py
    DESTINATION ${CMAKE_INSTALL_DATADIR}/knead/profiling/peers COMPONENT program)
# Scenes that it knows by their names.
install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/knead COMPONENT program
    FILES_MATCHING PATTERN *.json PATTERN *.hands PATTERN *.spz)

configure_package_config_file(cmake/KneadConfig.cmake.in
    ${CMAKE_CURRENT_BINARY_DIR}/KneadConfig.cmake INSTALL_DESTINATION ${package}
    NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/KneadConfigVersion.cmake
    COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/KneadConfig.cmake
    ${CMAKE_CURRENT_BINARY_DIR}/KneadConfigVersion.cmake cmake/FindZstd.cmake
    cmake/FindWebP.cmake
    DESTINATION ${package})
