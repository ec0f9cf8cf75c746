// All of Omma: load a scene and an eye, build a Renderer, render poses, save or paint responses.
#pragma once

#include "omma/acceptance.h"
#include "omma/camera.h"
#include "omma/error.h"
#include "omma/eye.h"
#include "omma/io.h"
#include "omma/pose.h"
#include "omma/projection.h"
#include "omma/receptor.h"
#include "omma/receptor_views.h"
#include "omma/render.h"
#include "omma/scene.h"
#include "omma/vec.h"
#include "omma/world.h"
