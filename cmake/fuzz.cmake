# The fuzz targets: one program for all formats, that every compiler builds, and with clang, where
# KNEAD_FUZZ asks for it, one of libFuzzer for each.
set(fuzz_sources formats mesh_formats cloud_formats session_formats)
list(TRANSFORM fuzz_sources PREPEND tests/fuzz/)
list(TRANSFORM fuzz_sources APPEND .cpp)

# What is fuzzed: of the libraries what reads files and runs what they say, once more, under
# sanitizers in every build. -O0 is built in less than half of the time of -O1, and quick enough.
# Asking of each pointer whether it is null, which ends the program anyway, or aligned takes a third
# of the compiler's time; a build with KNEAD_SANITIZE asks. Where the whole build has sanitizers, or
# counts lines, it is the library itself.
set(fuzzed_sanitizers -fsanitize=address,undefined -fno-sanitize-recover=undefined
    -fno-sanitize=null,alignment,vptr,object-size,nonnull-attribute,returns-nonnull-attribute)
include(CheckCXXSourceCompiles)
set(CMAKE_REQUIRED_FLAGS -fsanitize=address,undefined)
check_cxx_source_compiles("int main() {}" KNEAD_COMPILER_SANITIZES)
unset(CMAKE_REQUIRED_FLAGS)
if(KNEAD_SANITIZE OR KNEAD_COVERAGE OR KNEAD_STATIC OR NOT KNEAD_COMPILER_SANITIZES)
    set(fuzzed knead_app)
else()
    set(fuzzed knead_fuzzed)
    file(GLOB fuzzed_sources CONFIGURE_DEPENDS host/base/*.cpp host/files/*.cpp host/hands/*.cpp
        host/scene/*.cpp host/solver/*.cpp host/solver/*/*.cpp host/surface/*.cpp host/splats/*.cpp
        host/assets/*.cpp)
    list(APPEND fuzzed_sources host/cli/compare.cpp)
    list(FILTER fuzzed_sources EXCLUDE REGEX "raster|counters|assets/(fit|refine|skin|procedural)")
    foreach(name paging/local_state session/backend session/loop run/checkpoint run/depths
            run/left_out run/report run/run run/summary)
        list(APPEND fuzzed_sources host/${name}.cpp)
    endforeach()
    add_library(knead_fuzzed STATIC ${fuzzed_sources})
    target_include_directories(knead_fuzzed PUBLIC ${PROJECT_SOURCE_DIR})
    target_include_directories(knead_fuzzed SYSTEM PRIVATE ${XXHASH_INCLUDE_DIR}
        ${TINYGLTF_INCLUDE_DIR})
    target_compile_definitions(knead_fuzzed PRIVATE XXH_INLINE_ALL)
    # Warnings are for the libraries' own build.
    target_compile_options(knead_fuzzed PRIVATE -w PUBLIC -O0 -g1 ${fuzzed_sanitizers})
    target_link_options(knead_fuzzed PUBLIC ${fuzzed_sanitizers})
    target_link_libraries(knead_fuzzed PUBLIC nlohmann_json::nlohmann_json
        PRIVATE knead_options ${knead_fmt} Eigen3::Eigen CLI11::CLI11 PNG::PNG
        ZLIB::ZLIB ${CMAKE_DL_LIBS})
    knead_unite(knead_fuzzed cpp 1 fuzzed_files "host/files/|host/(paging|session|run|cli)/")
    knead_unite(knead_fuzzed cpp 1 fuzzed_scene "host/scene/|host/hands/|host/assets/")
    knead_unite(knead_fuzzed cpp 1 fuzzed_base "host/base/|host/surface/")
    knead_unite(knead_fuzzed cpp 1 fuzzed_solver
        "host/solver/|host/solver/cpu/|host/solver/gpu/|host/splats/")
    add_dependencies(knead_fuzzed knead_commit)
endif()
add_library(knead_fuzz_formats OBJECT ${fuzz_sources})
target_link_libraries(knead_fuzz_formats PUBLIC ${fuzzed} knead_options ${knead_fmt}
    GTest::gtest)
target_compile_definitions(knead_fuzz_formats PRIVATE XXH_INLINE_ALL)
add_executable(knead_fuzz tests/fuzz/driver.cpp tests/fuzz/mutate.cpp)
target_link_libraries(knead_fuzz PRIVATE knead_fuzz_formats)
if(KNEAD_SANITIZE OR fuzzed STREQUAL knead_fuzzed)
    target_compile_definitions(knead_fuzz PRIVATE KNEAD_SANITIZED=1)
endif()
check(fuzz tests/fuzz/some.sh $<TARGET_FILE:knead_fuzz> 1000)

if(KNEAD_FUZZ AND CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    foreach(format mesh-ply mesh-obj mesh-glb mesh-stl particles-ply particles-csv splats-ply
            splats-splat splats-spz scene settings run report checkpoint hands hands-lines)
        add_executable(fuzz-${format} tests/fuzz/libfuzzer.cpp)
        target_link_libraries(fuzz-${format} PRIVATE knead_fuzz_formats)
        target_link_options(fuzz-${format} PRIVATE -fsanitize=fuzzer)
        target_compile_definitions(fuzz-${format} PRIVATE KNEAD_FORMAT="${format}")
    endforeach()
endif()
