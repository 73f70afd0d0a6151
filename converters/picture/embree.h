// SPDX-License-Identifier: Apache-2.0
#pragma once

// Embree 3 (Debian 12) and 4 (Ubuntu 24.04) differ in how a ray is given its context.
#if OCTET_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace octet {

#if OCTET_EMBREE_MAJOR >= 4

using RayContext = RTCRayQueryContext;

inline void intersect(RTCScene scene, RayContext* context, RTCRayHit* ray) {
  rtcInitRayQueryContext(context);
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = context;
  rtcIntersect1(scene, ray, &arguments);
}

inline void occluded(RTCScene scene, RTCRay* ray) { rtcOccluded1(scene, ray); }

#else

using RayContext = RTCIntersectContext;

inline void intersect(RTCScene scene, RayContext* context, RTCRayHit* ray) {
  rtcInitIntersectContext(context);
  rtcIntersect1(scene, context, ray);
}

inline void occluded(RTCScene scene, RTCRay* ray) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, ray);
}

#endif

}  // namespace octet
