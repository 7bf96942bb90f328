# Sourced by the scripts that build. A compile cache serves every checkout of the project: paths below it are kept relative, and
# precompiled headers are taken for what they hold. What is set already stays.
export CCACHE_BASEDIR=${CCACHE_BASEDIR:-$PWD} CCACHE_NOHASHDIR=1
export CCACHE_SLOPPINESS=${CCACHE_SLOPPINESS:-pch_defines,time_macros,include_file_mtime,include_file_ctime}
