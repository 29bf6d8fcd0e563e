/** The dialog that is open, if any. */
import { dialog } from "../store";
import { FilterMenu } from "../filter/menu";
import { CommandDialog, OpenDialog, PictureDialog, SaveDialog, WriteDialog } from "./files";
import { HelpDialog } from "./help";
import { SearchDialog } from "./search";
import { SessionsDialog } from "./sessions";

export function Dialogs() {
  const open = dialog.value;
  switch (open?.name) {
    case "search": return <SearchDialog />;
    case "help": return <HelpDialog />;
    case "open": return <OpenDialog add={open.add} />;
    case "save": return <SaveDialog />;
    case "picture": return <PictureDialog plain={open.plain ?? false} />;
    case "sessions": return <SessionsDialog />;
    case "command": return <CommandDialog text={open.text} />;
    case "filters": return <FilterMenu after={open.after} />;
    case "write": return <WriteDialog dataset={open.dataset} />;
    default: return null;
  }
}
