/* In place of the view.h of travesty: Carom has no views. */
#pragma once

struct v3_plugin_view;
