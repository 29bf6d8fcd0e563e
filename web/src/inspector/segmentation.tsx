/** What of a volume is seen: the way first, then what that way needs; the transfer function has an editor of its own. */
import * as store from "../store";
import { TransferEditor } from "../transfer/editor";
import { Fold } from "../ui/controls";
import { join } from "../values";
import { Properties } from "./properties";
import { PropertyRow } from "./property_row";
import { useState } from "preact/hooks";

export function SegmentationPanel({ path, volume }: { path: string; volume: string }) {
  const [open, setOpen] = useState(true);
  const [more, setMore] = useState(false);
  const rows = store.classes.value["segmentation"]?.properties ?? [];
  const kindRow = rows.find((row) => row.name === "kind");
  const named = store.valueOf(join(path, "kind"));
  const kind = typeof named === "string" ? named : "transfer";
  const row = rows.find((r) => r.name === kind);
  return (
    <Fold id="segmentation" title={kind === "transfer" ? "Transfer function" : "Segmentation"} open={open} onToggle={setOpen}>
      {kindRow ? <div class="rows"><PropertyRow path={join(path, "kind")} row={kindRow} /></div> : null}
      {kind === "transfer" ? (
        <>
          <TransferEditor volume={volume} />
          <Fold id="transfer-more" title="More settings of the transfer function" open={more} onToggle={setMore}>
            <Properties path={join(path, "transfer")} className="transfer" skip={["opacity", "color"]} />
          </Fold>
        </>
      ) : row?.class ? <Properties path={join(path, kind)} className={row.class} /> : null}
    </Fold>
  );
}
