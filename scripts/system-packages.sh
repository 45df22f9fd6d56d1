#!/bin/sh
# Install the system packages that are missing: `system-packages.sh demo` or `... test`.
#
# A package counts as there if dpkg has it, or if the library or program that
# it stands for is found, whoever put it there. Where nothing is missing, no
# package manager is called. Only apt is driven; elsewhere what is missing is
# named.
set -eu

for_demo="libegl1 libgl1 libgl1-mesa-dri libglx-mesa0 libegl-mesa0 libgles2"
for_test="xvfb xauth xdotool chromium chromium-driver"

say() { echo "set-up: $*" >&2; }

has_command() { command -v "$1" >/dev/null 2>&1; }

# ldconfig is in sbin, which is not on every user's PATH.
libraries=$(PATH="$PATH:/usr/sbin:/sbin" ldconfig -p 2>/dev/null || true)

has_library() {
    case $libraries in *"$1"*) return 0 ;; esac
    return 1
}

has_software_renderer() {
    has_library libgallium && return 0 # Mesa 24.2 and later keep all drivers in it
    for driver in /usr/lib/*/dri/swrast_dri.so /usr/lib64/dri/swrast_dri.so /usr/lib/dri/swrast_dri.so; do
        [ -e "$driver" ] && return 0
    done
    return 1
}

# Is what Debian's package $1 brings on this system by any way?
is_there() {
    case $1 in
        libegl1) has_library libEGL.so.1 ;;
        libgl1) has_library libGL.so.1 ;;
        libgles2) has_library libGLESv2.so.2 ;;
        libegl-mesa0) has_library libEGL_mesa.so.0 ;;
        libglx-mesa0) has_library libGLX_mesa.so.0 ;;
        libgl1-mesa-dri) has_software_renderer ;;
        xvfb) has_command Xvfb ;;
        chromium-driver) has_command chromedriver ;;
        xauth | xdotool | chromium | python3) has_command "$1" ;;
        *) return 1 ;;
    esac
}

is_installed() {
    [ "$(dpkg-query -W -f='${db:Status-Status}\n' "$1" 2>/dev/null | sort -u)" = installed ]
}

# The package that lets Python make a .venv; Debian splits it off Python itself.
python_packages() {
    if ! has_command python3 && [ -z "${PYTHON:-}" ]; then
        sh scripts/find-python.sh >/dev/null 2>&1 || echo python3 python3-venv
        return
    fi
    python=$(sh scripts/find-python.sh) || return 1
    case $python in
        /usr/bin/*) "$python" -c 'import ensurepip' 2>/dev/null ||
            "$python" -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])' ;;
    esac
}

missing_of() {
    for package; do
        is_there "$package" || is_installed "$package" || printf ' %s' "$package"
    done
}

# apt as root; a half-way failing update (a foreign repository) need not stop the install.
apt_install() {
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=300 update ||
        say "apt-get update failed, going on with the package lists at hand"
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=300 \
        install --yes --no-install-recommends "$@"
}

case ${1:-} in
    demo) wanted=$for_demo ;;
    test) wanted="$for_demo $for_test" ;;
    *) say "found '${1:-}', wanted: system-packages.sh demo, or test" && exit 2 ;;
esac

if ! has_command apt-get || ! has_command dpkg-query; then
    [ -n "$libraries" ] || { say "cannot look for libraries here; vrlf needs OpenGL 4.3 by EGL" \
        "(Mesa or a vendor's driver) and, for the tests, Xvfb, xauth, xdotool, Chromium and its driver"; exit 0; }
    missing=$(missing_of $wanted)
    [ -z "$missing" ] && exit 0
    say "missing here, by the names of Debian's packages:$missing; install what brings them" \
        "(Fedora: mesa-libEGL mesa-libGL mesa-libGLES mesa-dri-drivers xorg-x11-server-Xvfb" \
        "xauth xdotool chromium chromedriver; Arch: mesa libglvnd xorg-server-xvfb xorg-xauth xdotool" \
        "chromium) and run make again"
    exit 1
fi

python_missing=$(python_packages)
missing="$(missing_of $wanted) $python_missing"
missing=$(echo $missing) # no spaces at the ends
[ -z "$missing" ] && exit 0

if [ "$(id -u)" -eq 0 ]; then
    as_root=""
elif has_command sudo && { sudo -n true 2>/dev/null || { [ -t 0 ] && sudo true; }; }; then
    as_root=sudo
else
    sudo=$(has_command sudo && echo "sudo " || true)
    say "system packages are missing and only root can install them; run this, then make again:"
    echo "${sudo}apt-get update && ${sudo}apt-get install --yes --no-install-recommends $missing" >&2
    exit 1
fi

say "installing system packages: $missing"
apt_install $missing || { say "apt-get could not install $missing (see above)"; exit 1; }
