# How the libraries' rooms are compiled.

# What waits for others is built in less time with -O1. Under sanitizers too, but for the solver.
set(knead_cold $<$<OR:$<CONFIG:Release>,$<BOOL:${KNEAD_SANITIZE}>>:-O1>)

# Verbs, sessions, tables, checks and headsets wait for the solver, files for the disk, and are not
# part of it: as quick with -O1, and compiled in less time. What is fuzzed has -O0.
set(cold_rooms cli paging session run live picture ui vr desktop bench verify files)
list(JOIN cold_rooms "|" cold_rooms)
set(cold_rooms "(host/(${cold_rooms})|/xr)/[^/]*\\.cpp$")
get_target_property(sources knead_app SOURCES)
list(FILTER sources INCLUDE REGEX ${cold_rooms})
set_source_files_properties(${sources} PROPERTIES COMPILE_OPTIONS
    $<$<NOT:$<STREQUAL:$<TARGET_PROPERTY:NAME>,knead_fuzzed>>:${knead_cold}>)

# These have flags of their own, are heavy alone, or include what takes names that others use
# (X11).
set(apart "host/base/machine\\.cpp|host/solver/(counters|reference)|files/gltf\\.cpp|\
render/(context|no_painter|view/no_window)|xr/(platform|no_headset)|\
tests/(base/machine|files/mesh_file)_test")

# In `text`, an include of the file. Files of tests name helpers alike: of these it is a copy whose
# unnamed namespace lies in one of the file's own, with the lines where they are.
function(knead_included path text)
    if(NOT path MATCHES "_test\\.cpp$")
        set(${text} "#include \"${path}\"\n" PARENT_SCOPE)
        return()
    endif()
    file(READ ${path} content)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${path})
    file(RELATIVE_PATH own ${PROJECT_SOURCE_DIR} ${path})
    string(MAKE_C_IDENTIFIER ${own} own)
    string(REPLACE "\nnamespace {\n" "\nnamespace of_${own} { namespace {\n" content "${content}")
    string(REPLACE "\n}  // namespace\n" "\n} }  // namespace\n" content "${content}")
    set(${text} "#line 1 \"${path}\"\n${content}" PARENT_SCOPE)
endfunction()

# In place of the target's sources of the rooms, `parts` files of the build folder, each of which
# holds its share of them; `form` is cpp or cu. `rooms` says how their paths begin, as an
# expression. Further arguments are the compiler's.
function(knead_unite target form parts name rooms)
    get_target_property(all ${target} SOURCES)
    set(some "")
    foreach(source IN LISTS all)
        cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE path)
        file(RELATIVE_PATH name_here ${PROJECT_SOURCE_DIR} ${path})
        if(name_here MATCHES "^(${rooms})[^/]*\\.${form}$" AND NOT name_here MATCHES ${apart})
            list(REMOVE_ITEM all ${source})
            list(APPEND some ${path})
        endif()
    endforeach()
    list(REMOVE_DUPLICATES some)
    list(LENGTH some count)
    if(count EQUAL 0)
        return()
    endif()
    math(EXPR share "(${count} + ${parts} - 1) / ${parts}")
    foreach(part RANGE 1 ${parts})
        math(EXPR from "(${part} - 1) * ${share}")
        if(from GREATER_EQUAL count)  # fewer files than parts
            break()
        endif()
        list(SUBLIST some ${from} ${share} files)
        set(text "")
        foreach(path IN LISTS files)
            knead_included(${path} one)
            string(APPEND text "${one}")
        endforeach()
        set(united ${CMAKE_CURRENT_BINARY_DIR}/united/${name}_${part}.${form})
        set(there "")
        if(EXISTS ${united})
            file(READ ${united} there)
        endif()
        if(NOT there STREQUAL text)
            file(WRITE ${united} "${text}")
        endif()
        set_source_files_properties(${united} PROPERTIES COMPILE_OPTIONS "${ARGN}")
        list(PREPEND all ${united})  # the longest first
    endforeach()
    set_target_properties(${target} PROPERTIES SOURCES "${all}")
endfunction()

# Where the scope of variables is watched, GCC keeps the vectors of the solver's loops in memory, and
# most of the tests' time was spent there. Its formulas are those of the reference and of tests,
# where scopes are watched; objects of splats and scenes are made by loops of the kind.
if(KNEAD_SANITIZE)
    set(unwatched -fno-sanitize-address-use-after-scope)
    target_compile_options(knead_solver PRIVATE $<$<COMPILE_LANGUAGE:CXX>:${unwatched}>)
    set_source_files_properties(host/solver/reference.cpp PROPERTIES
        COMPILE_OPTIONS -fsanitize-address-use-after-scope)
    get_target_property(sources knead_app SOURCES)
    list(FILTER sources INCLUDE REGEX "host/(assets|scene)/")
    set_source_files_properties(${sources} PROPERTIES COMPILE_OPTIONS ${unwatched})
endif()

if(KNEAD_UNITED)
    # The longest last. The others of host/verify name constants alike.
    knead_unite(knead_app cpp 1 checks_motion
        "host/verify/(bars|clay|front_imprint|front_sloshing|momentum)" ${knead_cold})
    knead_unite(knead_app cpp 1 headset "xr/" ${knead_cold})
    knead_unite(knead_app cpp 1 picture "render/|render/view/")
    knead_unite(knead_app cpp 1 files "host/files/" ${knead_cold})
    knead_unite(knead_app cpp 1 checks_tables
        "host/verify/(known|laws|processes|report|stability|verify|workprecision)" ${knead_cold})
    knead_unite(knead_app cpp 2 cli "host/cli/|host/desktop/" ${knead_cold})
    knead_unite(knead_app cpp 1 bench "host/bench/" ${knead_cold})
    knead_unite(knead_app cpp 1 assets "host/assets/" ${unwatched})
    knead_unite(knead_app cpp 1 scene "host/scene/|host/hands/" ${unwatched})
    knead_unite(knead_app cpp 1 checks_linear "host/verify/(oracle|scene_options|squeeze|waves)"
        ${knead_cold})
    knead_unite(knead_app cpp 1 session "host/(paging|session|run)/" ${knead_cold})
    knead_unite(knead_app cpp 1 live "host/(live|picture|ui|vr)/" ${knead_cold})
    knead_unite(knead_solver cpp 1 base "host/base/|host/surface/")
    knead_unite(knead_solver cpp 1 solver "host/solver/|host/splats/")
    knead_unite(knead_solver cu 1 device_solver "host/solver/gpu/")
    knead_unite(knead_solver cu 1 device_surface "host/surface/")
    knead_unite(knead_solver cu 1 device_splats "host/splats/")
endif()

# What most files include, read once; none of our own, whose names are not for everyone. Not of the
# libraries where warnings are errors: GCC then warns of what it inlines from the standard library's
# headers.
if(KNEAD_UNITED)
    set(knead_common <algorithm> <array> <chrono> <cmath> <filesystem> <functional> <map> <memory>
        <numbers> <optional> <string> <vector> <fmt/format.h> <nlohmann/json_fwd.hpp>)
endif()
if(KNEAD_UNITED AND NOT KNEAD_WERROR)
    target_precompile_headers(knead_app PRIVATE ${knead_common})
    target_precompile_headers(knead_solver PRIVATE ${knead_common})
    # These have definitions of their own.
    set_source_files_properties(render/view/no_window.cpp host/base/machine.cpp
        host/share/no_share.cpp host/solver/counters.cpp host/solver/cpu/levels.cpp PROPERTIES
        SKIP_PRECOMPILE_HEADERS ON)
endif()
