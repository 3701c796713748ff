//! The HTML of the episode player; its behaviour is in `assets/player.js`.

use super::episode::Episode;
use super::episode_json::EpisodeJson;
use super::error::ReportError;
use super::escape::{Escaped, script_json};
use std::fmt::Write;

/// One player for all `episodes` of section `number`.
pub(super) fn html(number: usize, episodes: &[Episode]) -> Result<String, ReportError> {
    episodes.iter().try_for_each(Episode::check)?;
    if episodes.is_empty() {
        return Ok("<p class=\"lead\">No episode was recorded.</p>".into());
    }
    let data: Vec<EpisodeJson> = episodes.iter().map(EpisodeJson::from).collect();
    let mut choice = String::new();
    if episodes.len() > 1 {
        choice += "<div class=\"choice\" role=\"group\" aria-label=\"Episode\">";
        for (index, episode) in episodes.iter().enumerate() {
            let pressed = index == 0;
            let title = Escaped(&episode.title);
            let _ = write!(
                choice,
                "<button type=\"button\" data-episode=\"{index}\" aria-pressed=\"{pressed}\">{title}</button>"
            );
        }
        choice += "</div>";
    }
    let markup = include_str!("../assets/player.html").replace('\n', "").replace("{number}", &number.to_string());
    Ok(format!(
        "<div class=\"player\" data-player tabindex=\"0\" role=\"group\" aria-label=\"Episode player\" \
         aria-describedby=\"keys-{number}\">{choice}{markup}\
         <noscript><p class=\"lead\">Playing an episode needs JavaScript.</p></noscript>\
         <script type=\"application/json\">{}</script></div>",
        script_json(&data)?
    ))
}
