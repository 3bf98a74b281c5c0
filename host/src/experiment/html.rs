//! One page with everything: figures inline, no scripts, no other files, readable without a network.

use std::fmt::Write as _;

use super::{Finished, table::escape_html};
use crate::error::InputError;

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;max-width:76rem;margin:2rem auto;padding:0 1rem;color:#222}\
h1{font-size:1.6rem}h2{font-size:1.3rem;margin-top:3rem;border-top:1px solid #ddd;padding-top:1rem}\
table{border-collapse:collapse;margin:1rem 0;display:block;overflow-x:auto}\
caption{text-align:left;font-weight:600;padding:.3rem 0}\
th,td{padding:.2rem .7rem;text-align:right;border-bottom:1px solid #ddd;font-variant-numeric:tabular-nums}\
th{background:#f4f4f4}.words{text-align:left}figure{margin:1.5rem 0}figure svg{max-width:100%;height:auto}\
figcaption{color:#555}code{background:#f4f4f4;padding:.1rem .3rem}";

/// The page of some experiments, in their order.
///
/// # Errors
/// A figure with nothing to draw.
pub fn page(finished: &[Finished]) -> Result<String, InputError> {
    let title = match finished {
        [one] => format!("varsac experiment {}", one.experiment.name),
        _ => "varsac: the experiments".to_owned(),
    };
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>{title}</title>\n<style>{STYLE}</style>\n\
         </head>\n<body>\n<h1>{title}</h1>\n"
    );
    if finished.len() > 1 {
        text.push_str("<ul>\n");
        for Finished { experiment, .. } in finished {
            let (name, purpose) = (experiment.name, escape_html(experiment.purpose));
            let _ = writeln!(text, "<li><a href=\"#{name}\">{name}</a>: {purpose}</li>");
        }
        text.push_str("</ul>\n");
    }
    for one in finished {
        section(&mut text, one)?;
    }
    text.push_str("</body>\n</html>\n");
    Ok(text)
}

fn section(text: &mut String, finished: &Finished) -> Result<(), InputError> {
    let Finished { experiment, report, seed, .. } = finished;
    let name = experiment.name;
    let _ = writeln!(text, "<h2 id=\"{name}\">{name}</h2>\n<p>{}</p>", escape_html(experiment.purpose));
    if !report.findings.is_empty() {
        text.push_str("<ul>\n");
        for finding in &report.findings {
            let _ = writeln!(text, "<li>{}</li>", escape_html(finding));
        }
        text.push_str("</ul>\n");
    }
    for table in &report.tables {
        text.push_str(&table.to_html());
    }
    for figure in &report.figures {
        let svg = figure.to_svg()?;
        let _ = writeln!(
            text,
            "<figure>\n{svg}<figcaption>{}</figcaption>\n</figure>",
            escape_html(&figure.caption)
        );
    }
    let _ = writeln!(text, "<p>Made by <code>varsac experiment {name} --seed {seed}</code>.</p>");
    Ok(())
}
