# What the libraries need, and what they use where it is found: KNEAD_GL, KNEAD_XR, KNEAD_PANEL and
# KNEAD_WINDOW are off afterwards where something is missing. knead_cuda, knead_gl, knead_panel,
# knead_window and knead_xr say what was found.
find_package(Threads REQUIRED)
find_package(Eigen3 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(fmt REQUIRED)
find_package(PNG REQUIRED)
find_package(ZLIB REQUIRED)
list(APPEND CMAKE_MODULE_PATH ${CMAKE_CURRENT_LIST_DIR})
find_package(Zstd REQUIRED)
find_path(XXHASH_INCLUDE_DIR xxhash.h REQUIRED)
find_path(FAST_FLOAT_INCLUDE_DIR fast_float/fast_float.h REQUIRED)
find_path(TINYGLTF_INCLUDE_DIR tiny_gltf.h REQUIRED)

# Images of SOG, a format of splats.
option(KNEAD_WEBP "Build SOG, a format of splats, where libwebp is found" ON)
set(knead_sog "no SOG (KNEAD_WEBP is off)")
if(KNEAD_WEBP)
    find_package(WebP)
    set(KNEAD_WEBP ${WebP_FOUND})
    set(knead_sog "no SOG (libwebp was not found)")
endif()
if(KNEAD_WEBP)
    set(knead_sog "SOG by libwebp")
endif()

# fmt as it is, or as it can be carried to another machine.
set(knead_fmt fmt::fmt)
if(KNEAD_STATIC)
    set(knead_fmt fmt::fmt-header-only)
endif()

# Only headers are needed: libEGL is opened when a picture is asked for, and the functions of OpenGL
# are found through it.
find_path(EGL_INCLUDE_DIR EGL/egl.h)
find_path(GL_CORE_INCLUDE_DIR GL/glcorearb.h)
if(NOT KNEAD_GL)
    set(knead_gl "no pictures (KNEAD_GL is off)")
elseif(EGL_INCLUDE_DIR AND GL_CORE_INCLUDE_DIR)
    set(knead_gl "pictures by OpenGL through EGL")
else()
    set(KNEAD_GL OFF)
    set(knead_gl "no pictures (the headers EGL/egl.h and GL/glcorearb.h were not both found)")
endif()

# The same of the headset: OpenXR's loader, and X11 where it serves, are opened when asked for.
find_path(OPENXR_INCLUDE_DIR openxr/openxr.h)
if(NOT KNEAD_XR)
    set(knead_xr "no headset (KNEAD_XR is off)")
elseif(OPENXR_INCLUDE_DIR)
    find_path(GLX_INCLUDE_DIR GL/glx.h)
    find_path(X11_XLIB_INCLUDE_DIR X11/Xlib.h)
    set(knead_xr "headset by OpenXR through")
    set(knead_xr_includes ${OPENXR_INCLUDE_DIR})
    set(knead_xr_definitions KNEAD_HAS_XR=1)
    if(EGL_INCLUDE_DIR)
        list(APPEND knead_xr_includes ${EGL_INCLUDE_DIR})
        list(APPEND knead_xr_definitions KNEAD_HAS_EGL=1)
        string(APPEND knead_xr " EGL")
    endif()
    if(GLX_INCLUDE_DIR AND X11_XLIB_INCLUDE_DIR)
        list(APPEND knead_xr_includes ${GLX_INCLUDE_DIR} ${X11_XLIB_INCLUDE_DIR})
        list(APPEND knead_xr_definitions KNEAD_HAS_GLX=1)
        string(APPEND knead_xr " GLX")
    endif()
else()
    set(KNEAD_XR OFF)
    set(knead_xr "no headset (the header openxr/openxr.h was not found)")
endif()

# Clay in the shape of a text: a header that includes its own source.
find_path(STB_INCLUDE_DIR stb_truetype.h PATH_SUFFIXES stb)

# The panels of window and headset, and captions of pictures: Dear ImGui is linked.
find_path(IMGUI_INCLUDE_DIR imgui.h PATH_SUFFIXES imgui)
find_library(IMGUI_LIBRARY imgui)
find_library(STB_LIBRARY stb)
if(NOT (KNEAD_PANEL AND KNEAD_GL))
    set(KNEAD_PANEL OFF)
    set(knead_panel "no panels (KNEAD_PANEL or KNEAD_GL is off)")
elseif(IMGUI_INCLUDE_DIR AND IMGUI_LIBRARY AND STB_LIBRARY AND
        EXISTS ${IMGUI_INCLUDE_DIR}/backends/imgui_impl_opengl3.h)
    set(knead_panel "panels by Dear ImGui")
else()
    set(KNEAD_PANEL OFF)
    set(knead_panel "no panels (Dear ImGui was not found)")
endif()

# The window: of GLFW only the header is needed, its library is opened when a window is asked for.
find_path(GLFW_INCLUDE_DIR GLFW/glfw3.h)
if(NOT (KNEAD_WINDOW AND KNEAD_GL))
    set(KNEAD_WINDOW OFF)
    set(knead_window "no window (KNEAD_WINDOW or KNEAD_GL is off)")
elseif(GLFW_INCLUDE_DIR)
    set(knead_window "a window by GLFW")
else()
    set(KNEAD_WINDOW OFF)
    set(knead_window "no window (GLFW/glfw3.h was not found)")
endif()

if(KNEAD_CUDA)
    find_package(CUDAToolkit REQUIRED)
    # CUDA's header for sharing memory with OpenGL includes one of OpenGL's.
    find_path(GL_INCLUDE_DIR GL/gl.h)
    if(GL_INCLUDE_DIR AND KNEAD_GL)
        set(knead_share ON)
        string(APPEND knead_cuda ", shared with OpenGL")
    else()
        set(knead_share OFF)
        string(APPEND knead_cuda ", not shared with OpenGL (GL/gl.h was not found)")
    endif()
    # Only headers are needed: the library is opened when something is to be counted.
    find_path(CUPTI_INCLUDE_DIR cupti_range_profiler.h
        HINTS ${CMAKE_CUDA_TOOLKIT_INCLUDE_DIRECTORIES} PATH_SUFFIXES . ../extras/CUPTI/include
        ../../../extras/CUPTI/include)
    if(CUPTI_INCLUDE_DIR)
        string(APPEND knead_cuda ", counters by CUPTI")
    else()
        string(APPEND knead_cuda ", no counters (CUPTI 12.6 or newer was not found)")
    endif()
endif()
