# What waits for the solver or for the disk is as quick with -O1, and compiled in less time. Under
# sanitizers tests are, too.
set(knead_cold $<$<OR:$<CONFIG:Release>,$<BOOL:${KNEAD_SANITIZE}>>:-O1>)
# Where the scope of variables is watched, GCC keeps the vectors of the solver's loops in memory,
# and most of the tests' time was spent there. Its formulas are those of the reference and of tests,
# where scopes are watched; objects of splats and scenes are made by loops of the kind.
if(KNEAD_SANITIZE)
    set(knead_unwatched -fno-sanitize-address-use-after-scope)
endif()

# UNITY_BUILD is of CUDA, too, from CMake 3.31 on. Until then, with KNEAD_UNITED: puts one file that
# includes all others, NAME.cu, in place of a list of .cu files.
function(knead_unite_cuda list name)
    list(LENGTH ${list} count)
    if(KNEAD_UNITED AND count GREATER 1)
        list(TRANSFORM ${list} REPLACE "(.+)" "#include \"\\1\"\n" OUTPUT_VARIABLE includes)
        list(JOIN includes "" includes)
        set(one ${CMAKE_CURRENT_BINARY_DIR}/${name}.cu)
        file(CONFIGURE OUTPUT ${one} CONTENT "${includes}" @ONLY)
        set(${list} ${one} PARENT_SCOPE)
    endif()
endfunction()

# The calling folder's files as a part of the library `solver` or `app`: an object library, named
# knead_FOLDER and given in the variable `room`. FLAGS are those of the C++ compiler. With
# KNEAD_UNITED the files are compiled together, but for those that are listed after APART.
function(knead_room library)
    cmake_parse_arguments(PARSE_ARGV 1 with "" "" "SOURCES;FLAGS;APART")
    file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
    string(MAKE_C_IDENTIFIER knead_${folder} name)
    set(room ${name} PARENT_SCOPE)
    set(cuda_sources "")
    if(NOT with_SOURCES)
        file(GLOB with_SOURCES CONFIGURE_DEPENDS *.cpp)
        if(KNEAD_CUDA)
            file(GLOB cuda_sources CONFIGURE_DEPENDS *.cu)
        endif()
    endif()
    set(united ${KNEAD_UNITED})
    if(folder MATCHES "^cuda/")  # each file of kernels is heavy alone
        set(united OFF)
    else()
        knead_unite_cuda(cuda_sources united)
    endif()
    add_library(${name} OBJECT ${with_SOURCES} ${cuda_sources})
    target_link_libraries(${name} PRIVATE knead_${library}_room)
    target_compile_options(${name} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:${with_FLAGS}>)
    set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ON
        CUDA_RUNTIME_LIBRARY Static UNITY_BUILD ${united} UNITY_BUILD_BATCH_SIZE 0)
    if(library STREQUAL "solver" AND PROJECT_IS_TOP_LEVEL)
        # What ptxas says of every kernel is kept beside its object, for tests/kernels_test.sh.
        target_compile_options(${name} PRIVATE $<$<COMPILE_LANGUAGE:CUDA>:-Xptxas=-v>)
        set_property(TARGET ${name} PROPERTY CUDA_COMPILER_LAUNCHER
            ${PROJECT_SOURCE_DIR}/tests/keep_ptxas.sh ${CMAKE_CUDA_COMPILER_LAUNCHER})
    endif()
    set_source_files_properties(${with_APART} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    target_sources(knead_${library} PRIVATE $<TARGET_OBJECTS:${name}>)
endfunction()

# The calling folder as a room, of which DRAWING includes Dear ImGui: those files are compiled
# apart, so that no other is compiled with its headers' folder. A build without panels has WITHOUT
# in their place.
function(knead_drawing_room without)
    cmake_parse_arguments(PARSE_ARGV 1 with "" "" "DRAWING")
    file(GLOB sources CONFIGURE_DEPENDS *.cpp)
    list(TRANSFORM with_DRAWING PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ OUTPUT_VARIABLE drawing)
    list(REMOVE_ITEM sources ${drawing})
    knead_room(app SOURCES ${sources} FLAGS ${knead_cold} APART ${without})
    if(NOT KNEAD_PANEL)
        return()
    endif()
    add_library(${room}_drawing OBJECT ${drawing})
    target_link_libraries(${room}_drawing PRIVATE knead_app_room)
    target_include_directories(${room}_drawing SYSTEM PRIVATE ${IMGUI_INCLUDE_DIR})
    target_compile_options(${room}_drawing PRIVATE ${knead_cold})
    set_target_properties(${room}_drawing PROPERTIES POSITION_INDEPENDENT_CODE ON)
    target_sources(knead_app PRIVATE $<TARGET_OBJECTS:${room}_drawing>)
    set_source_files_properties(${without} PROPERTIES COMPILE_DEFINITIONS KNEAD_HAS_PANEL=1)
    target_link_libraries(knead_app PRIVATE ${IMGUI_LIBRARY} ${STB_LIBRARY})
endfunction()
