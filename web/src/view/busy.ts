/** Whether the Navigator shows another picture soon, as far as the page can know: by what hands did, by edits, by the server. */
import { computed } from "@preact/signals";
import { atRest, making, shown } from "../navigator/choice";
import * as store from "../store";

/** The page's own drawing is not the last while the shapes of it are under way. */
const isOwnLast = computed(() => store.pose.value?.moving === false && !making.value);

export const isBusy = computed(() =>
  store.connection.value.state !== "open" || store.unheard.value || store.unanswered.value > 0 ||
  !(shown.value && atRest.value ? isOwnLast.value : store.isFinal.value || store.failed.value !== null));
