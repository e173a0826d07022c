# What demo.sh and test.sh share: getting what the build needs, and saying what is being done.
# Sourced, from the top of the tree.

say() { printf '\n== %s\n' "$*"; }

# Debian 12 and Ubuntu 24.04 have all of these; nothing is fetched from anywhere else.
build_packages=(g++ cmake ninja-build libeigen3-dev libcli11-dev nlohmann-json3-dev libfmt-dev
    libpng-dev zlib1g-dev libzstd-dev libwebp-dev libxxhash-dev libfast-float-dev libtinygltf-dev
    libegl-dev libegl1 libgl1-mesa-dri libopenxr-dev libopenxr-loader1 libgl-dev libx11-dev
    libglfw3-dev libimgui-dev
    fonts-dejavu-core)

installed() {
    case $1 in
        g++ | cmake) command -v "$1" >/dev/null && return ;;
        ninja-build) command -v ninja >/dev/null && return ;;
    esac
    dpkg-query -W -f='${Status}' "$1" 2>/dev/null | grep -q 'ok installed'
}

# Installs the packages named, where missing.
install() {
    if ! command -v apt-get >/dev/null; then
        say "No apt-get here. What is needed, by its Debian names: $*"
        return
    fi
    mkdir -p build
    local missing=() package as_root=()
    for package in "$@"; do
        installed "$package" || missing+=("$package")
    done
    [ ${#missing[@]} -eq 0 ] && return
    say "Installing from the distribution's mirror: ${missing[*]}"
    if [ "$(id -u)" -ne 0 ]; then
        if ! command -v sudo >/dev/null; then
            echo "This needs root, and there is no sudo. As root: apt-get install ${missing[*]}" >&2
            exit 1
        fi
        as_root=(sudo)
    fi
    local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y)
    "${apt[@]}" update >/dev/null || echo "The list of packages could not be renewed." >&2
    if ! "${apt[@]}" install --no-install-recommends "${missing[@]}" >build/apt.log 2>&1; then
        tail -n 5 build/apt.log >&2
        echo "Not installed (see build/apt.log); the build will say what it cannot do without." >&2
    fi
}

# Whether there is an NVIDIA card to run on.
gpu_present() { nvidia-smi -L >/dev/null 2>&1; }
