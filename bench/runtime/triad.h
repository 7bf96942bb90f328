/// How fast this machine streams through memory, now.
#pragma once

/// Bandwidth of a = b + s c, bytes/s: the best of some runs over arrays that no cache holds. Measured once.
double triadBandwidth();
