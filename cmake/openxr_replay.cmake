# The replay runtime, the program that probes it, and its manifest, for tests of the headset.
file(GLOB replay_sources CONFIGURE_DEPENDS tests/openxr_replay/*.cpp)
list(FILTER replay_sources EXCLUDE REGEX "(probe|misuse)\\.cpp$")
add_library(openxr_replay MODULE ${replay_sources})
target_link_libraries(openxr_replay PRIVATE knead_app knead_options ${knead_fmt} ${CMAKE_DL_LIBS})
target_include_directories(openxr_replay SYSTEM PRIVATE ${OPENXR_INCLUDE_DIR} ${EGL_INCLUDE_DIR}
    ${GLX_INCLUDE_DIR})
# Only the entry is seen from outside. What it knows outlives its being closed by the loader: frames
# and faults go on over a lost instance.
set_target_properties(openxr_replay PROPERTIES CXX_VISIBILITY_PRESET hidden)
target_link_options(openxr_replay PRIVATE -Wl,--exclude-libs,ALL -Wl,-z,nodelete)
target_compile_options(openxr_replay PRIVATE ${knead_cold})
if(knead_common)
    target_precompile_headers(openxr_replay PRIVATE ${knead_common} <nlohmann/json.hpp>)
endif()
file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/openxr_replay.json CONTENT
    "{\"file_format_version\": \"1.0.0\", \"runtime\": {\"name\": \"Knead replay\",
    \"library_path\": \"$<TARGET_FILE:openxr_replay>\"}}\n")

foreach(program probe misuse)
    add_executable(openxr_${program} tests/openxr_replay/${program}.cpp)
    target_include_directories(openxr_${program} SYSTEM PRIVATE ${OPENXR_INCLUDE_DIR})
    target_link_libraries(openxr_${program} PRIVATE knead_app knead_options)
endforeach()
if(TARGET knead_tests)
    target_sources(knead_tests PRIVATE tests/openxr_replay/flow.cpp tests/openxr_replay/script.cpp)
    target_include_directories(knead_tests SYSTEM PRIVATE ${OPENXR_INCLUDE_DIR})
    target_compile_definitions(knead_tests PRIVATE
        KNEAD_XR_PROBE="$<TARGET_FILE:openxr_probe>"
        KNEAD_XR_MISUSE="$<TARGET_FILE:openxr_misuse>"
        KNEAD_XR_RUNTIME="${CMAKE_BINARY_DIR}/openxr_replay.json"
        KNEAD_XR_PROGRAM="$<TARGET_FILE:knead>")
    add_dependencies(knead_tests openxr_probe openxr_misuse openxr_replay knead)
endif()
check(xr_validation tests/xr/validation.sh $<TARGET_FILE:knead>
    ${CMAKE_BINARY_DIR}/openxr_replay.json)
# The layer and what draws leak, and are gone when leaks are told: they cannot be named.
if(KNEAD_SANITIZE)
    set_tests_properties(xr_validation PROPERTIES ENVIRONMENT ASAN_OPTIONS=detect_leaks=0)
endif()
