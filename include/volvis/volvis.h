/** @file
 * All of the public interface of VolVis.
 */
#ifndef VOLVIS_VOLVIS_H
#define VOLVIS_VOLVIS_H
#include <volvis/about.h>
#include <volvis/base.h>
#include <volvis/compare.h>
#include <volvis/field.h>
#include <volvis/file.h>
#include <volvis/image.h>
#include <volvis/measure.h>
#include <volvis/measure_distance.h>
#include <volvis/measure_mesh.h>
#include <volvis/measure_path.h>
#include <volvis/measuring.h>
#include <volvis/mesh.h>
#include <volvis/mesh_file.h>
#include <volvis/model.h>
#include <volvis/operation.h>
#include <volvis/pick.h>
#include <volvis/preview.h>
#include <volvis/property.h>
#include <volvis/render.h>
#include <volvis/run.h>
#include <volvis/runtime.h>
#include <volvis/status.h>
#include <volvis/vec.h>
#include <volvis/version.h>
#endif
