/** @file
 * What those who write recordings and those who play them share.
 */
#ifndef VVI_SERVER_RECORDING_IMPL_H
#define VVI_SERVER_RECORDING_IMPL_H

/** What the first line of a recording has. */
#define VVI_RECORDING_HEAD "volvis session"
#endif
