#!/bin/sh
# Debian packages below a folder, without root and without touching the system: apt with a state of its own reads the
# system's sources, keys and list of packages, and a script for each program finds the unpacked libraries.
#
#     debian.sh FOLDER update                                reads the lists of packages
#     debian.sh FOLDER plan NAME PACKAGES                    which files are needed that the system does not have
#     debian.sh FOLDER unpack NAME PACKAGES PROGRAMS LINKS   fetches and unpacks them into FOLDER/NAME
#
# PROGRAMS are places with patterns; LINKS, which the packages make when they are installed, are PLACE:TARGET. Scripts
# are in FOLDER/NAME/bin. A library of C is not unpacked: a program starts with the loader of the system, and with no
# other library of C than its own.
set -eu
folder=$1 action=$2 name=${3-} packages=${4-} programs=${5-} links=${6-}
apt=$folder/apt
export LC_ALL=C

# The system's list of installed packages without those that are to be unpacked and those of the same source, which look
# for each other beside them; without relations, so that no installed package hinders another one.
status() {
    awk -v wanted=" $packages " -v sources=" $1 " 'BEGIN { RS = ""; FS = "\n" } {
        name = source = kept = ""
        for (k = 1; k <= NF; k++) {
            if ($k ~ /^Package: /) name = substr($k, 10)
            if ($k ~ /^Source: /) { source = substr($k, 9); sub(/ \(.*/, "", source) }
            if ($k ~ /^(Package|Status|Architecture|Multi-Arch|Version|Provides): /) kept = kept $k "\n"
        }
        if (source == "") source = name
        if (!index(wanted, " " name " ") && !index(sources, " " source " ")) print kept
    }' /var/lib/dpkg/status
}

install() {
    # shellcheck disable=SC2086
    apt-get --config-file "$apt/apt.conf" install -o "Dir::State::status=$apt/status-$name" \
        -o "Dir::Cache::archives=$apt/archives-$name" "$@" $packages
}

case $action in
update)
    mkdir -p "$apt/lists/partial" "$apt/archives/partial"
    # Hooks of the system would write outside. An address that does not answer ends the command in its first minute.
    cat > "$apt/apt.conf" <<END
Dir::State "$apt";
Dir::State::lists "$apt/lists";
Dir::State::status "$apt/status";
Dir::Cache "$apt";
#clear APT::Update::Pre-Invoke;
#clear APT::Update::Post-Invoke;
#clear APT::Update::Post-Invoke-Success;
#clear DPkg::Post-Invoke;
Acquire::IndexTargets::deb::DEP-11::DefaultEnabled "false";
Acquire::IndexTargets::deb::Contents-deb::DefaultEnabled "false";
Acquire::Languages "none";
Acquire::Retries "1";
Acquire::http::Timeout "10";
Acquire::https::Timeout "10";
APT::Get::Assume-Yes "true";
APT::Get::allow-change-held-packages "true";
APT::Get::allow-downgrades "true";
APT::Get::allow-remove-essential "true";
APT::Install-Recommends "false";
APT::Keep-Downloaded-Packages "true";
APT::Sandbox::User "root";
Debug::NoLocking "true";
END
    status "" > "$apt/status"
    echo "reading the lists of packages"
    # A source of another project may be out of reach; it matters if what is missing is not in the others.
    apt-get --config-file "$apt/apt.conf" --quiet --quiet update || true
    ;;
plan)
    mkdir -p "$apt/archives-$name/partial"
    # shellcheck disable=SC2086
    sources=$(apt-cache --config-file "$apt/apt.conf" show --no-all-versions $packages |
        awk '/^Package: / { name = $2 } /^Source: / { name = $2 } /^$/ { print name } END { print name }' | tr '\n' ' ')
    status "$sources" > "$apt/status-$name"
    install --print-uris > "$apt/uris"
    sed -n "s/^'[^']*' \([^ ]*\) .*/\1/p" "$apt/uris" | grep -v -e '^libc6_' -e '^libc-bin_' > "$apt/files-$name"
    ;;
unpack)
    root=$folder/$name part=$folder/$name.part
    install --download-only --quiet --quiet
    rm -rf "$part" "$root"
    mkdir -p "$part/bin" "$folder/bin"
    while read -r file; do dpkg-deb --extract "$apt/archives-$name/$file" "$part"; done < "$apt/files-$name"
    for link in $links; do ln -s "${link#*:}" "$part/${link%%:*}"; done
    # Absolute links lead to what is unpacked.
    find "$part" -type l | while read -r link; do
        target=$(readlink "$link")
        case $target in /*) [ ! -e "$part$target" ] || ln -sfnr "$part$target" "$link" ;; esac
    done
    # The descriptions of C libraries name folders of the system.
    [ ! -d "$part/usr/lib/arm-none-eabi/newlib" ] ||
        find "$part/usr/lib/arm-none-eabi/newlib" -name '*.specs' -exec sed -i "s| /usr/| $root/usr/|g" {} +
    libraries=$(find "$part" -name 'lib*.so*' -printf "$root/%P\n" | sed 's|/[^/]*$||' | sort -u | paste -sd: -)
    settings=
    [ -z "$libraries" ] || settings="export LD_LIBRARY_PATH='$libraries'\${LD_LIBRARY_PATH:+:\$LD_LIBRARY_PATH}"
    if [ -d "$part/usr/share/fonts" ]; then
        # The configuration of the packages names folders of the system only.
        cat > "$part/fonts.conf" <<END
<?xml version="1.0"?>
<!DOCTYPE fontconfig SYSTEM "urn:fontconfig:fonts.dtd">
<fontconfig>
  <dir>/usr/share/fonts</dir>
  <dir>$root/usr/share/fonts</dir>
  <cachedir>$root/cache</cachedir>
</fontconfig>
END
        settings="$settings FONTCONFIG_FILE='$root/fonts.conf'" # Chromium always has libraries
    fi
    for program in $programs; do
        for place in "$part"/$program; do
            words="'$root/${place#"$part"/}'"
            # The script names the compiler's library by a way that is in no workspace: by its plain name it is inside of
            # this one and outside of all others, where cargo calls it by different names, and each workspace would
            # compile `core` again for the same target directory.
            case $place in */rustc) words="$words --sysroot '/proc/self/root$root/usr'" ;; esac
            printf '#!/bin/sh\n%s\nexec %s "$@"\n' "$settings" "$words" > "$part/bin/${place##*/}"
            chmod +x "$part/bin/${place##*/}"
        done
    done
    mv "$part" "$root"
    rm -r "$apt/archives-$name"
    ;;
esac
