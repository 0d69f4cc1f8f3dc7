// A pupil's part of the drawer, loaded for pupils alone: it follows the class and shows what is to
// be done.
// Leaves to others: its parts (pupil.js, pupil_panel.js), when it is wanted (drawers/class.js).
// Invariant: who only looks into the drawer loads nothing of it.

import { followClass } from "./pupil.js";
import { mountPupil } from "./pupil_panel.js";

export default { followClass, mountPupil };
