//! Pages that need no other file.

use base64::Engine as _;
use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment};
use serde::Serialize;

/// Fills a template, which may include `style.css` and what `more` adds; text is escaped.
pub(crate) fn html(
    template: &'static str,
    content: &impl Serialize,
    more: impl FnOnce(&mut Environment<'static>),
) -> String {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    add(&mut environment, "index.html", template);
    add(&mut environment, "style.css", include_str!("style.css"));
    more(&mut environment);
    let page = environment.get_template("index.html").expect("added above");
    page.render(Serde(content))
        .expect("the template fits its content")
}

/// Adds a template.
pub(crate) fn add(
    environment: &mut Environment<'static>,
    name: &'static str,
    template: &'static str,
) {
    environment
        .add_template(name, template)
        .expect("the template is valid");
}

/// A PNG file as a `data:` address.
pub(crate) fn address(png: &[u8]) -> String {
    let base64 = base64::engine::general_purpose::STANDARD;
    format!("data:image/png;base64,{}", base64.encode(png))
}
