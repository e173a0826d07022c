# The window: Dear ImGui is linked; of GLFW only the header is needed, its library is opened when a
# window is asked for.
option(KNEAD_WINDOW "Build the window where GLFW's headers and Dear ImGui are found" ON)
find_path(GLFW_INCLUDE_DIR GLFW/glfw3.h)
find_path(IMGUI_INCLUDE_DIR imgui.h PATH_SUFFIXES imgui)
find_library(IMGUI_LIBRARY imgui)
find_library(STB_LIBRARY stb)
set(knead_window "no window (KNEAD_WINDOW or KNEAD_GL is off)")
if(KNEAD_WINDOW AND KNEAD_GL AND EGL_INCLUDE_DIR)
    set(knead_window "no window (GLFW/glfw3.h or Dear ImGui was not found)")
    if(GLFW_INCLUDE_DIR AND IMGUI_INCLUDE_DIR AND IMGUI_LIBRARY AND STB_LIBRARY AND
            EXISTS ${IMGUI_INCLUDE_DIR}/backends/imgui_impl_opengl3.h)
        # Apart, so that no other file is compiled with their headers' folders.
        add_library(knead_window OBJECT render/view/window.cpp render/view/panels.cpp)
        target_include_directories(knead_window PRIVATE ${PROJECT_SOURCE_DIR})
        target_include_directories(knead_window SYSTEM PRIVATE ${GLFW_INCLUDE_DIR}
            ${IMGUI_INCLUDE_DIR} ${GL_CORE_INCLUDE_DIR})
        target_link_libraries(knead_window PRIVATE knead_options)
        set_target_properties(knead_window PROPERTIES POSITION_INDEPENDENT_CODE ON)
        target_sources(knead_app PRIVATE $<TARGET_OBJECTS:knead_window>)
        set_source_files_properties(render/view/no_window.cpp PROPERTIES
            COMPILE_DEFINITIONS KNEAD_HAS_WINDOW=1)
        target_link_libraries(knead_app PRIVATE ${IMGUI_LIBRARY} ${STB_LIBRARY})
        set(knead_window "a window by GLFW and Dear ImGui")
    endif()
endif()
