//! A report to files: a table as Markdown and JSON, figures as SVG and PNG, one page with all of it.

use std::path::{Path, PathBuf};

use super::{Finished, html};
use crate::error::{InputError, write_whole};

/// Writes the files of some experiments into `folder`, which is made if need be; returns the page, which holds
/// everything: `NAME.html` of one experiment, `index.html` of several. Each file is written whole or not at all.
///
/// # Errors
/// When the folder cannot be made or written to.
pub fn write(finished: &[Finished], folder: &Path) -> Result<PathBuf, InputError> {
    std::fs::create_dir_all(folder).map_err(|error| {
        InputError::in_file(folder, format!("cannot be made ({error})"), "choose another folder with --out")
    })?;
    for one in finished {
        let name = one.experiment.name;
        let file = |end: &str| folder.join(format!("{name}{end}"));
        write_whole(&file(".md"), one.to_markdown().as_bytes())?;
        write_whole(&file(".json"), pretty(&one.to_json()).as_bytes())?;
        for figure in &one.report.figures {
            write_whole(&file(&format!("-{}.svg", figure.name)), figure.to_svg()?.as_bytes())?;
            write_whole(&file(&format!("-{}.png", figure.name)), &figure.to_png()?)?;
        }
    }
    let page = match finished {
        [one] => folder.join(format!("{}.html", one.experiment.name)),
        _ => folder.join("index.html"),
    };
    write_whole(&page, html::page(finished)?.as_bytes())?;
    Ok(page)
}

/// JSON with line breaks, so that two runs can be compared by eye.
pub fn pretty(value: &serde_json::Value) -> String {
    format!("{value:#}\n")
}
